//! Small readers of OFF, OBJ and binary PLY, for the folder of shared test meshes.
//!
//! The folder is `../shared/meshes` beside the repository, or what SMOOTH_POLYLINES_MESHES names; its meshes are not part
//! of the project. Reads what those files hold, and no more of the formats.

use std::path::{Path, PathBuf};

use glam::DVec3;

use super::shapes::Shape;

/// The shared mesh `name`; `None`, with a message, where there is no such folder.
///
/// # Panics
/// When the folder is there and the mesh is not, or cannot be read: that is a mistake, and not a machine without meshes.
pub fn shared_mesh(name: &str) -> Option<Shape> {
    let folder = std::env::var_os("SMOOTH_POLYLINES_MESHES").filter(|folder| !folder.is_empty());
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/meshes");
    let folder = folder.map_or_else(beside, PathBuf::from);
    if !folder.is_dir() {
        tell_missing(name, &folder);
        return None;
    }
    let path = folder.join(name);
    let bytes = std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let shape = match path.extension().and_then(|suffix| suffix.to_str()) {
        Some("off") => read_off(&bytes),
        Some("obj") => read_obj(&bytes),
        Some("ply") => read_ply(&bytes),
        _ => None,
    };
    Some(shape.unwrap_or_else(|| panic!("{} is no mesh that this reader understands", path.display())))
}

#[expect(clippy::print_stderr, reason = "a test that cannot run says what it misses")]
fn tell_missing(name: &str, folder: &Path) {
    eprintln!(
        "NOT RUN on {name}: no folder {}; set SMOOTH_POLYLINES_MESHES to the folder of test meshes",
        folder.display()
    );
}

/// Triangles of polygons, each cut into a fan from its first corner.
fn fans<'a>(polygons: impl Iterator<Item = &'a [u32]>) -> Vec<[u32; 3]> {
    polygons.flat_map(|p| p[1..].windows(2).map(|pair| [p[0], pair[0], pair[1]]).collect::<Vec<_>>()).collect()
}

fn read_off(bytes: &[u8]) -> Option<Shape> {
    let text = std::str::from_utf8(bytes).ok()?;
    let lines = text.lines().map(|line| line.split('#').next().unwrap_or_default());
    let mut words = lines.flat_map(str::split_whitespace);
    if words.next()? != "OFF" {
        return None;
    }
    let mut count = || words.next()?.parse::<usize>().ok();
    let (vertices, faces, _) = (count()?, count()?, count()?);
    let mut positions = Vec::with_capacity(vertices);
    for _ in 0..vertices {
        let mut number = || words.next()?.parse::<f64>().ok();
        positions.push(DVec3::new(number()?, number()?, number()?));
    }
    let mut polygons = Vec::with_capacity(faces);
    for _ in 0..faces {
        let corners = words.next()?.parse::<usize>().ok()?;
        polygons.push((0..corners).map(|_| words.next()?.parse().ok()).collect::<Option<Vec<u32>>>()?);
    }
    Some(Shape { positions, triangles: fans(polygons.iter().map(Vec::as_slice)) })
}

fn read_obj(bytes: &[u8]) -> Option<Shape> {
    let text = std::str::from_utf8(bytes).ok()?;
    let (mut positions, mut polygons) = (Vec::new(), Vec::new());
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let mut number = || words.next()?.parse::<f64>().ok();
                positions.push(DVec3::new(number()?, number()?, number()?));
            }
            Some("f") => {
                let corner = |word: &str| word.split('/').next()?.parse::<u32>().ok()?.checked_sub(1);
                polygons.push(words.map(corner).collect::<Option<Vec<u32>>>()?);
            }
            _ => {}
        }
    }
    Some(Shape { positions, triangles: fans(polygons.iter().map(Vec::as_slice)) })
}

/// Binary little-endian, three floats a vertex, and faces as a list of ints after a byte.
fn read_ply(bytes: &[u8]) -> Option<Shape> {
    const END: &[u8] = b"end_header\n";
    let end = bytes.windows(END.len()).position(|window| window == END)?;
    let header = std::str::from_utf8(&bytes[..end]).ok()?;
    let count = |element: &str| {
        let line = header.lines().find_map(|line| line.strip_prefix("element ")?.strip_prefix(element))?;
        line.trim().parse::<usize>().ok()
    };
    let properties = header.lines().filter(|line| line.starts_with("property")).collect::<Vec<_>>();
    let is_known = header.contains("binary_little_endian")
        && properties.len() == 4
        && properties[..3].iter().all(|line| line.starts_with("property float "))
        && properties[3].starts_with("property list uchar int ");
    if !is_known {
        return None;
    }
    let mut rest = &bytes[end + END.len()..];
    let mut take = |count: usize| {
        let (head, tail) = rest.split_at_checked(count)?;
        rest = tail;
        Some(head)
    };
    let mut positions = Vec::with_capacity(count("vertex")?);
    for _ in 0..count("vertex")? {
        let mut number = || Some(f64::from(f32::from_le_bytes(take(4)?.try_into().ok()?)));
        positions.push(DVec3::new(number()?, number()?, number()?));
    }
    let mut polygons = Vec::with_capacity(count("face")?);
    for _ in 0..count("face")? {
        let corners = usize::from(take(1)?[0]);
        let ids = take(4 * corners)?.chunks(4).map(|id| id.try_into().ok().map(u32::from_le_bytes));
        polygons.push(ids.collect::<Option<Vec<u32>>>()?);
    }
    Some(Shape { positions, triangles: fans(polygons.iter().map(Vec::as_slice)) })
}
