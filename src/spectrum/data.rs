//! The tables that come with the program: comma-separated values, by names.
//!
//! `src/spectrum/data/generate.py` writes them from published data; comments name the sources. They
//! are read when a name is asked for.

/// Lines of a table that are no comments.
pub fn lines(table: &str) -> impl Iterator<Item = &str> {
    table.lines().filter(|line| !line.is_empty() && !line.starts_with('#'))
}

/// What follows after a name in the lines of a table that start with it.
pub fn entries<'a>(table: &'a str, name: &'a str) -> impl Iterator<Item = &'a str> {
    lines(table).filter_map(|line| line.split_once(',')).filter_map(move |(first, rest)| {
        let is_it = first == name;
        is_it.then_some(rest)
    })
}

/// The names in a table, each once, in its order.
pub fn names(table: &'static str) -> Vec<&'static str> {
    let mut names: Vec<&str> =
        lines(table).filter_map(|line| Some(line.split_once(',')?.0)).collect();
    names.dedup();
    names
}

/// The name among others that is this one in capitals or not.
pub fn known(names: Vec<&'static str>, name: &str) -> Option<&'static str> {
    names.into_iter().find(|known| known.eq_ignore_ascii_case(name))
}

/// The numbers of a line; none if a cell is no number.
pub fn numbers(line: &str) -> Option<Vec<f64>> {
    line.split(',').map(|cell| cell.parse().ok()).collect()
}
