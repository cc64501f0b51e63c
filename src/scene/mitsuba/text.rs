//! Numbers, lists and spectra out of attributes, and parameters put into them.

use std::collections::BTreeMap;

use super::tree::{Curve, NAME};
use crate::math::text::{excerpt, listed};

/// The words of a list: between blanks and commas.
pub fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| c == ',' || c.is_whitespace()).filter(|word| !word.is_empty())
}

/// A finite number.
pub fn number(text: &str) -> Result<f64, String> {
    let number = text.trim().parse::<f64>().ok().filter(|number| number.is_finite());
    number.ok_or_else(|| format!("`{}` is not a number", excerpt(text, NAME)))
}

/// All numbers of a list.
pub fn numbers(text: &str) -> Result<Vec<f64>, String> {
    words(text).map(number).collect()
}

/// A spectrum: a number, or `nm:value` pairs in the order of their wavelengths.
pub fn curve(text: &str) -> Result<Curve, String> {
    let pair = |word: &str| match word.split_once(':') {
        Some((nm, value)) => Ok([number(nm)?, number(value)?]),
        None => Err(format!("`{}` is not a pair nm:value", excerpt(word, NAME))),
    };
    let list: Vec<&str> = words(text).collect();
    match list[..] {
        [only] if !only.contains(':') => number(only).map(Curve::Uniform),
        _ => table(list.into_iter().map(pair).collect::<Result<_, _>>()?),
    }
}

/// A spectrum of the lines of a file: a wavelength and a value each, behind `#` a comment.
pub fn curve_of_lines(text: &str) -> Result<Curve, String> {
    let mut pairs = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or_default();
        let at = |problem: String| format!("line {}: {problem}", index + 1);
        match numbers(line).map_err(at)?[..] {
            [] => {}
            [nm, value] => pairs.push([nm, value]),
            _ => return Err(at("is not a wavelength and a value".to_owned())),
        }
    }
    table(pairs)
}

/// A table of pairs, checked.
pub fn table(pairs: Vec<[f64; 2]>) -> Result<Curve, String> {
    if pairs.is_empty() {
        return Err("has no values".to_owned());
    }
    // As they are kept.
    if !pairs.is_sorted_by(|a, b| (a[0] as f32) < b[0] as f32) || pairs[0][0] <= 0.0 {
        return Err("needs wavelengths above zero in increasing order".to_owned());
    }
    Ok(Curve::Table(pairs))
}

/// The parameters of a file, which stand in attributes as `$name`.
#[derive(Clone, Debug, Default)]
pub struct Parameters {
    values: BTreeMap<String, String>,
    /// Those that came from outside, and nothing in the file has asked for.
    unused: Vec<String>,
}

impl Parameters {
    /// Those from outside, by name.
    pub fn new(definitions: &[(String, String)]) -> Self {
        let values: BTreeMap<_, _> = definitions.iter().cloned().collect();
        Self { unused: values.keys().cloned().collect(), values }
    }

    /// What holds if nothing else is said.
    pub fn default(&mut self, name: &str, value: &str) {
        self.unused.retain(|unused| unused != name);
        self.values.entry(name.to_owned()).or_insert_with(|| value.to_owned());
    }

    /// The text with its parameters put in, the longest name that fits each; `\$` is a dollar.
    pub fn put_into(&mut self, text: &str) -> Result<String, String> {
        let mut done = String::new();
        let mut rest = text;
        while let Some(at) = rest.find('$') {
            let (before, name) = (&rest[..at], &rest[at + 1..]);
            if let Some(before) = before.strip_suffix('\\') {
                done += before;
                done.push('$');
                rest = name;
                continue;
            }
            done += before;
            let fitting = self.values.iter().filter(|(known, _)| name.starts_with(&**known));
            let Some((known, value)) = fitting.max_by_key(|(known, _)| known.len()) else {
                let end = name.find(|c: char| !c.is_alphanumeric() && c != '_');
                let name = excerpt(&name[..end.unwrap_or(name.len())], NAME);
                return Err(format!("the parameter ${name} is not defined"));
            };
            done += value;
            rest = &name[known.len()..];
            self.unused.retain(|unused| unused != known);
        }
        Ok(done + rest)
    }

    /// What is wrong with those from outside that nothing has asked for, and what there is.
    pub fn unused(&self) -> Option<(String, String)> {
        let unused = self.unused.first()?;
        let problem = format!("the scene has no parameter `{}`", excerpt(unused, NAME));
        let known: Vec<&String> =
            self.values.keys().filter(|name| !self.unused.contains(name)).collect();
        let remedy = match known.is_empty() {
            true => "it has none at all".to_owned(),
            false => format!("it has {}", listed(known)),
        };
        Some((problem, remedy))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_are_put_in_by_their_longest_names() {
        let own = [("a".to_owned(), "1".to_owned()), ("ab".to_owned(), "2".to_owned())];
        let mut parameters = Parameters::new(&own);
        parameters.default("c", "3");
        parameters.default("a", "4");
        assert_eq!(parameters.put_into("$a $ab$c \\$a x"), Ok("1 23 $a x".to_owned()));
        assert_eq!(parameters.unused(), None);
        let error = parameters.put_into("$d-1").unwrap_err();
        assert_eq!(error, "the parameter $d is not defined");
        let unused = Parameters::new(&own[..1]).unused();
        let expected = ("the scene has no parameter `a`", "it has none at all");
        assert_eq!(unused.as_ref().map(|(a, b)| (&**a, &**b)), Some(expected));
    }

    #[test]
    fn spectra_are_numbers_or_pairs() {
        assert_eq!(curve(" 0.5 "), Ok(Curve::Uniform(0.5)));
        let table = Curve::Table(vec![[400.0, 0.1], [500.0, 0.2]]);
        assert_eq!(curve("400:0.1, 500:0.2"), Ok(table.clone()));
        assert_eq!(curve_of_lines("# nm value\n400 0.1\n\n500 0.2 # end"), Ok(table));
        for wrong in ["", "a", "500:1, 400:2", "400:1 400:2", "0:1", "400:inf", "400:1 2"] {
            assert!(curve(wrong).is_err(), "{wrong}");
        }
        assert!(curve_of_lines("400 1 2").is_err() && curve_of_lines("# nothing").is_err());
    }
}
