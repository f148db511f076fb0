//! Arguments that are one word out of a few, and the hint when the word is nearly right.

use pyo3::prelude::*;
use pyo3::types::PyString;

use crate::errors::{option_error, type_error};

/// The value that a word names; else an OptionError that lists the choices and the nearest one.
pub fn choose<T: Copy>(argument: &'static str, value: &Bound<'_, PyAny>, choices: &[(&str, T)]) -> PyResult<T> {
    let names = || choices.iter().map(|(name, _)| *name).collect::<Vec<&str>>();
    let Ok(word) = value.cast::<PyString>() else {
        let found = value.get_type().name()?;
        return Err(type_error(argument, format_args!("found {found}, expected one of {}", list_words(&names()))));
    };
    let word = word.to_cow()?;
    choices
        .iter()
        .find_map(|(name, choice)| (*name == word).then_some(*choice))
        .ok_or_else(|| option_error(value.py(), argument, refuse_word(&word, &names(), "")))
}

fn list_words(names: &[&str]) -> String {
    names.iter().map(|name| format!("{name:?}")).collect::<Vec<_>>().join(", ")
}

/// What to say about a word that is none of `names`; `also` tells what else than a word would do.
pub fn refuse_word(word: &str, names: &[&str], also: &str) -> String {
    let listed = list_words(names);
    // A novel passed by mistake is neither compared nor repeated in full.
    let shown: String = word.chars().take(40).collect();
    let near = names
        .iter()
        .map(|name| (edit_distance(&shown.to_lowercase(), name), *name))
        .min_by_key(|(distance, _)| *distance)
        .filter(|(distance, name)| *distance <= name.chars().count().div_ceil(3));
    match near {
        Some((_, name)) => format!("found {shown:?}, expected one of {listed}{also}; did you mean {name:?}?"),
        None => format!("found {shown:?}, expected one of {listed}{also}"),
    }
}

/// Fewest insertions, deletions and replacements of characters (Levenshtein 1965); time in the product of the lengths.
fn edit_distance(left: &str, right: &str) -> usize {
    let right: Vec<char> = right.chars().collect();
    let mut row: Vec<usize> = (0..=right.len()).collect();
    for (i, a) in left.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, b) in right.iter().enumerate() {
            let replaced = diagonal + usize::from(a != *b);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[right.len()]
}
