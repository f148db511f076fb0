//! Every way a request can be refused, as typed errors whose messages name the argument, what was
//! found, what was expected and what to do next.
//!
//! Argument names in messages are those of the public interface (`positions`, `triangles`, `picks`).
//! What is *not* an error: a line that did not converge (that is a stop reason in its report).

use thiserror::Error;

/// The mesh cannot be used.
#[derive(Error, Clone, PartialEq, Debug)]
pub enum MeshError {
    /// A triangle names a vertex that does not exist.
    #[error(
        "triangles[{triangle}] names vertex {index}, but positions has {vertices} rows (0 to {}); \
         correct the index or pass all positions", *vertices as i64 - 1
    )]
    IndexOutOfRange {
        /// Row of `triangles`.
        triangle: usize,
        /// The value found there.
        index: i128,
        /// Rows of `positions`.
        vertices: usize,
    },
    /// A vertex that a triangle uses is not at a finite place.
    #[error(
        "positions[{vertex}] is {position:?}, but a vertex used by a triangle (here triangles[{triangle}]) \
         must be finite; correct or remove it"
    )]
    NotFinite {
        /// Row of `positions`.
        vertex: u32,
        /// The value found there.
        position: [f64; 3],
        /// The first triangle that uses it.
        triangle: usize,
    },
    /// A vertex so far out that squares of lengths overflow.
    #[error(
        "positions[{vertex}] is {position:?}; coordinates beyond 1e150 overflow when lengths are squared: scale the mesh down"
    )]
    TooFar {
        /// Row of `positions`.
        vertex: u32,
        /// The value found there.
        position: [f64; 3],
    },
    /// A triangle that is not one: it names a vertex twice.
    #[error(
        "triangles[{triangle}] is {corners:?} and repeats a vertex; a triangle needs three different ones: \
         remove such rows first"
    )]
    RepeatedVertex {
        /// Row of `triangles`.
        triangle: usize,
        /// The value found there.
        corners: [u32; 3],
    },
    /// `triangle_faces` does not fit `triangles`.
    #[error(
        "triangle_faces has {found} entries, but triangles has {expected} rows; pass one face id for each triangle"
    )]
    FaceCount {
        /// Entries of `triangle_faces`.
        found: usize,
        /// Rows of `triangles`.
        expected: usize,
    },
    /// A face id that cannot be one.
    #[error("triangle_faces[{triangle}] is {face}, but a face id is from 0 to 4294967294; renumber the faces")]
    FaceOutOfRange {
        /// Entry of `triangle_faces`.
        triangle: usize,
        /// The value found there.
        face: i128,
    },
    /// More elements than ids.
    #[error("{argument} has {found} rows, but at most {limit} can be numbered; split the mesh")]
    TooLarge {
        /// `positions` or `triangles`.
        argument: &'static str,
        /// Rows found.
        found: usize,
        /// Most rows that can be handled.
        limit: usize,
    },
}

/// An argument of a request is out of its range, or arguments contradict each other.
///
/// `message` says what was found, what was expected and what to do.
#[derive(Error, Clone, PartialEq, Eq, Debug)]
#[error("{argument}: {message}")]
pub struct OptionError {
    /// The argument at fault, as the caller knows it.
    pub argument: &'static str,
    /// Found, expected, and the advice.
    pub message: String,
}

impl OptionError {
    /// An error about `argument`.
    pub fn new(argument: &'static str, message: impl Into<String>) -> Self {
        Self { argument, message: message.into() }
    }

    /// The same error, where what it calls picks are the points of a stroke.
    pub fn about_points(self) -> Self {
        match self.argument {
            "picks" => {
                let renamed = self.message.strip_prefix("pick ").map(|rest| format!("point {rest}"));
                Self { argument: "points", message: renamed.unwrap_or(self.message) }
            }
            _ => self,
        }
    }
}

/// Why no line could be made.
#[derive(Error, Clone, PartialEq, Debug)]
pub enum Error {
    /// See [`MeshError`].
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// See [`OptionError`].
    #[error(transparent)]
    Option(#[from] OptionError),
    /// Two consecutive picks cannot be joined.
    #[error(
        "{argument} {first} and {second} lie on parts of the mesh that are not connected ({parts} parts); \
         join them or merge vertices by distance first"
    )]
    NoPath {
        /// What they are called: `picks`, or `points` of a stroke.
        argument: &'static str,
        /// Position in the argument.
        first: usize,
        /// Position in the argument.
        second: usize,
        /// Parts of the mesh, where a part is what can be reached across edges of two triangles.
        parts: usize,
    },
    /// A closed line shrank until nothing was left.
    #[error(
        "the closed line shrank to a point after {iterations} rounds: nothing on the surface holds it open; \
         pin some picks (pinned=\"all\"), or use a filter that keeps the shape (fair with a detail_size)"
    )]
    Collapsed {
        /// Rounds until then.
        iterations: u32,
    },
    /// Lines cannot be put into the mesh.
    #[error(
        "the lines cross each other in triangle {triangle} in a way that rounding does not let be untangled; cut with a \
         larger tolerance, or with fewer lines at once"
    )]
    Tangled {
        /// Row of `triangles`.
        triangle: usize,
    },
    /// The observer asked to stop.
    #[error("stopped by the caller before the line was finished")]
    Interrupted,
}

impl Error {
    /// The same error with picks named by their places in a longer list: `places[i]` is where pick `i` stands.
    pub fn with_picks(self, places: [usize; 2]) -> Self {
        match self {
            Self::NoPath { argument, first, second, parts } => {
                Self::NoPath { argument, first: places[first], second: places[second], parts }
            }
            Self::Option(OptionError { argument: "picks", message }) => {
                // Messages of the picks begin with the pick that they are about.
                let renamed = places.iter().enumerate().find_map(|(i, place)| {
                    let rest = message.strip_prefix(&format!("pick {i}"))?;
                    rest.starts_with([' ', ':']).then(|| format!("pick {place}{rest}"))
                });
                OptionError::new("picks", renamed.unwrap_or(message)).into()
            }
            other => other,
        }
    }
}

/// What most functions return.
pub type Result<T, E = Error> = std::result::Result<T, E>;
