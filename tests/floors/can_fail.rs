//! The checker can fail: sources that break each rule, and sources that only look as if they did.

use super::pages::check_page;
use super::sources::{Floors, Source, Tree, floors_of, read};
use super::{STAGES, rules_without_ground, violations};

/// What a source breaks by itself, one a line; its documentation is added.
fn broken_by(file: &str, text: &str) -> String {
    broken_together(&[(file, text)])
}

/// What sources break together.
fn broken_together(sources: &[(&str, &str)]) -> String {
    let source = |(file, text): &(&str, &str)| Source::new(file, &format!("//! A file.\n{text}\n"));
    let floors = floors_of(&read("src/lib.rs"));
    violations(&Tree::new(sources.iter().map(source).collect(), floors)).join("\n")
}

/// A stage's documentation and head, in a file of its name.
fn stage(name: &str, clauses: &str, parameters: &str) -> (String, String) {
    let text = format!("/// Does.\n///\n{clauses}\npub fn {name}({parameters}) {{}}");
    (format!("{STAGES}{name}.rs"), text)
}

/// What one stage breaks that comes from and goes to nothing.
fn broken_by_stage(columns: &str, parameters: &str) -> String {
    let clauses = format!("/// From: nothing. To: nothing.\n/// {columns}");
    let (file, text) = stage("a", &clauses, parameters);
    broken_by(&file, &text)
}

/// Asserts that each case breaks one rule, the expected one.
fn assert_each_breaks_one(cases: &[(&str, &str, &str)]) {
    for (file, text, expected) in cases {
        let found = broken_by(file, text);
        assert!(found.contains(expected), "{file}: {text}: {found:?} lacks {expected:?}");
        assert_eq!(found.lines().count(), 1, "{found}");
    }
}

#[test]
fn imports_that_climb_are_found() {
    assert_each_breaks_one(&[
        ("src/math/a.rs", "use crate::film::Film;", "upward import: math (0) uses film (3)"),
        ("src/film/a.rs", "use crate::{math::F32s, cli::{run, x}};", "film (3) uses cli (12)"),
        ("src/spectrum/a.rs", "use crate::polarization::Stokes;", "sideways import"),
        ("src/scene/a/b.rs", "fn f() { super::super::super::render::save() }", "uses render (9)"),
        ("src/geometry/mod.rs", "use super::transport::Chunk;", "uses transport (7)"),
        ("src/transport/mis.rs", "use crate::polarization::Stokes;", "never see Stokes values"),
        ("src/film/a.rs", "pub use crate::math::F32s;", "re-exports from another floor: math"),
        ("src/film/a.rs", "pub(crate) use crate::math;", "re-exports from another floor: math"),
    ]);
    let head = Source::new("src/film/mod.rs", "//! Floor 4: sums.\n");
    let tree = Tree::new(vec![head], floors_of(&read("src/lib.rs")));
    assert!(violations(&tree).join("").contains("says floor 4, and film is on floor 3"));
}

#[test]
fn crates_out_of_place_are_found() {
    let cases = [
        ("src/film/a.rs", "use hecs::World;"),
        ("src/image/a.rs", "fn f(a: gltf::Gltf) {}"),
        ("src/transport/a.rs", "use obvhs;"),
        ("src/film/a.rs", "use exr::prelude::*;"),
        ("src/cli/a.rs", "use plotters::prelude::*;"),
        ("src/image/a.rs", "#[derive(clap::Parser)] struct A;"),
        ("src/spectrum/a.rs", "use rayon::prelude::*;"),
        ("src/render/a.rs", "use tev_client::TevClient;"),
    ];
    for (file, text) in cases {
        assert!(broken_by(file, text).contains("is known in"), "{file}: {text}");
    }
}

#[test]
fn sizes_and_unfinished_code_are_found() {
    let long_function = format!("fn f() {{\n{}}}", "    g();\n".repeat(70));
    let cases = [
        ("fn f() { todo!() }".to_owned(), "`todo!`"),
        ("fn f() { dbg!(1); }".to_owned(), "`dbg!`"),
        ("#[allow(dead_code)]\nfn f() {}".to_owned(), "without a reason"),
        (format!("// {}", "x".repeat(98)), "101 columns"),
        (long_function, "`f` has 72 lines"),
        ("\n".repeat(600), "602 lines"),
    ];
    for (text, expected) in cases {
        let found = broken_by("tests/a.rs", &text);
        assert!(found.contains(expected), "{found:?} lacks {expected:?}");
    }
    let undocumented = Source::new("src/film/a.rs", "use std::fs;");
    let found = violations(&Tree::new(vec![undocumented], Floors::new()));
    assert!(found[0].contains("starts with its"), "{found:?}");
}

#[test]
fn catch_alls_on_kinds_are_found() {
    let file = "src/film/a.rs";
    let found = |body: &str| broken_by(file, &format!("enum Kind<T> {{ A, B(T), C }}\n{body}"));
    let wrong = [
        "fn f(k: Kind) -> u8 { match k { Kind::A => 1, _ => 0 } }",
        "fn f(k: Kind) -> u8 { match k { a::Kind::B(_) if g(k) => 1, other => h(other) } }",
        "fn f(k: Kind) -> u8 { match g(k) { Some(Kind::C) => { 1 } Some(_) => 0, None => 2 } }",
        "fn f(k: Kind) -> u8 { match (k, 1) { (Kind::A, 1) => c::<A, B<u8>>(1), (_, _) => 0 } }",
        "impl<T> Kind<T> { fn f(&self) -> u8 { match self { Self::A | Self::C => 1, _ => 0 } } }",
        "fn f(k: Kind) -> u8 { match k { Kind::A => match 2 { _ => 1 }, _ if g() => 3, x => 0 } }",
    ];
    for text in wrong {
        let found = found(text);
        assert!(found.contains("a catch-all in a match on `Kind`"), "{text}: {found:?}");
        assert_eq!(found.lines().count(), 1, "{text}: {found}");
    }
    let right = [
        "fn f(k: Kind) -> u8 { match k { Kind::A => 1, Kind::B(_) | Kind::C => 0 } }",
        "fn f(k: u8) -> Kind { match k { 0 => Kind::A, _ => Kind::C } }",
        "fn f(k: Kind) -> u8 { match k { _ if g() => 2, Kind::A => 1, Kind::B(x) => x } }",
        "fn f(k: Mode) -> u8 { match k { other::Kind::Triangles => 1, _ => 0 } }",
        "fn f(k: Kind) -> u8 { match k { Kind::A => match 1 { 1 => 2, _ => 3 }, Kind::C => 0 } }",
        "fn f(k: Kind, n: u8) -> u8 { match (k, n) { (Kind::A, _) => 1, (Kind::C, n) => n } }",
    ];
    for text in right {
        assert_eq!(found(text), "", "{text}");
    }
    assert_eq!(broken_by("tests/a.rs", &format!("enum Kind {{ A, B }} {}", wrong[0])), "");
}

#[test]
fn wavelengths_in_geometry_are_found() {
    let text = "pub fn f<const N: usize>(a: &Tables<N>) {}";
    assert!(broken_by("src/geometry/a.rs", text).contains("knows a number of wavelengths"));
    assert_eq!(broken_by("src/geometry/a.rs", &text.replace("N:", "LANES:")), "");
    assert_eq!(broken_by("src/scattering/a.rs", text), "");
}

#[test]
fn stages_with_wrong_columns_are_found() {
    let right = [
        ("Writes: a, b. Reads: c.", "a: &mut A, b: &mut [B; 2], c: &[C]"),
        ("Writes: a (x, y), b.\n/// Reads: c (z), d.", "(a, b): (&mut A, &mut B), c: &'x C, d: D"),
        ("Writes: a, b. Reads: nothing.", "[a, b]: &mut [A; 2], n: u32, (e, r): (E, Range<u8>)"),
        ("Writes: nothing. Reads: c, d.", "c: Option<&C>, d: View<'_, f32>, f: impl Fn(&mut A)"),
        ("Writes: a. Reads: nothing.", "mut a: ViewMut<'_, A>, n: F32s"),
        ("Writes: a (x). Reads: a (y), b.", "a: &mut A, b: &B"),
    ];
    let fields = "\nfn columns() { (x, y, z) }";
    for (columns, parameters) in right {
        let clauses = format!("/// From: nothing. To: nothing.\n/// {columns}");
        let (file, text) = stage("a", &clauses, parameters);
        assert_eq!(broken_by(&file, &(text + fields)), "", "{columns} {parameters}");
    }
    let wrong = [
        ("Writes: a. Reads: c.", "a: &mut A, b: &mut B, c: &C", "Writes lacks `b`"),
        ("Writes: a, b. Reads: c.", "a: &mut A, b: &B, c: &C", "Writes names `b` wrongly"),
        ("Writes: a. Reads: b.", "a: &mut A, (b, c): (&B, &C)", "Reads lacks `c`"),
        ("Writes: a. Reads: b, beta.", "a: &mut A, b: &B", "Reads names `beta` wrongly"),
        ("Writes: a (x). Reads: b.", "a: &mut A, b: &B", "Writes `a` has no `x` here"),
        ("Writes: nothing. Reads: b.", "b: &Option<&mut B>", "Writes lacks `b`"),
        ("Writes: a. Reads: the scene, b.", "a: &mut A, b: &B", "is no list of names"),
        ("Writes: a. Reads: b, of course", "a: &mut A, b: &B", "is no list of names"),
        ("Reads: b.", "a: &mut A, b: &B", "says nothing after `Writes:`"),
        ("Writes: a. Reads: b.", "b: &B, a: &mut A", "takes an input before an output"),
    ];
    for (columns, parameters, expected) in wrong {
        let found = broken_by_stage(columns, parameters);
        assert!(found.contains(expected), "{columns} {parameters}: {found:?} lacks {expected:?}");
    }
}

#[test]
fn stages_with_wrong_neighbors_are_found() {
    let found = |of_a: &str, of_b: &str| {
        let clauses = |own: &str| format!("/// {own}\n/// Writes: nothing. Reads: nothing.");
        let [a, b] = [stage("a", &clauses(of_a), ""), stage("b", &clauses(of_b), "")];
        let traced = ("src/geometry/walk.rs", "pub fn trace_closest() {}");
        broken_together(&[(&a.0, &a.1), (&b.0, &b.1), traced])
    };
    let right = [
        ("From: nothing. To: b.", "From: a. To: nothing."),
        ("From: b, trace_closest. To: b, a.", "From: a. To: a, the film."),
    ];
    let own = "From: b, a, trace_closest. To: b, a.";
    for (of_a, of_b) in [right[0], (own, right[1].1)] {
        assert_eq!(found(of_a, of_b), "", "{of_a} {of_b}");
    }
    let wrong = [
        (
            "From: nothing. To: b.",
            "From: nothing. To: nothing.",
            "`a` is To: b, whose From lacks it",
        ),
        (
            "From: nothing. To: nothing.",
            "From: a. To: nothing.",
            "`b` is From: a, whose To lacks it",
        ),
        (
            "From: c. To: nothing.",
            "From: nothing. To: nothing.",
            "`a` is From: c, which is no stage",
        ),
        ("From: nothing. To: resolve_surfaces.", "From: nothing. To: nothing.", "no function"),
        ("To: nothing.", "From: nothing. To: nothing.", "`a` says nothing after `From:`"),
    ];
    for (of_a, of_b, expected) in wrong {
        let found = found(of_a, of_b);
        assert!(found.contains(expected), "{of_a} {of_b}: {found:?} lacks {expected:?}");
        assert_eq!(found.lines().count(), 1, "{found}");
    }
}

#[test]
fn stages_out_of_shape_are_found() {
    let six = "a: &mut [(u8, u8); 2], (b, c, d): (u8, u8, u8), e: impl Fn(u8, u8) -> (u8, u8), \
               f: u8";
    let columns = "Writes: a. Reads: nothing.";
    assert_eq!(broken_by_stage(columns, six), "");
    let [seven, tuple] = [format!("{six}, g: u8,"), six.replace("f: u8", "f: (u8, Vec<u8>)")];
    for parameters in [&seven, &tuple] {
        assert!(broken_by_stage(columns, parameters).contains("`a` has 7 parameters"));
    }
    let clauses = "/// From: nothing. To: nothing.\n/// Writes: nothing. Reads: nothing.";
    let (file, text) = stage("a", clauses, "");
    let wrong_name = broken_by(&format!("{STAGES}b.rs"), &text);
    assert!(wrong_name.contains("no `pub fn b`"), "{wrong_name}");
    let method = format!("trait T {{\n{clauses}\nfn b(&mut self);\n}}");
    for (more, expected) in [
        (method.as_str(), "`b` has a `self`"),
        ("pub struct S;", "`struct S` leaves a stage"),
        ("pub trait T {}", "`trait T` leaves a stage"),
        ("pub(super) fn f() {}", "`fn f` leaves a stage"),
        ("pub(crate) const C: u8 = 1;", "`const C` leaves a stage"),
        ("pub use crate::math::F32s as f;", "`use crate` leaves a stage"),
        ("pub fn undocumented() {}", "says nothing after `From:`"),
    ] {
        let found = broken_by(&file, &format!("{text}\n{more}"));
        assert!(found.contains(expected), "{more}: {found:?} lacks {expected:?}");
    }
    let innocent = "struct S { pub a: u8 }\nimpl S { pub fn f(&self) {} }\nconst fn g() {}\n\
                    mod tests { pub fn h() {} }";
    assert_eq!(broken_by(&file, &format!("{text}\n{innocent}")), "");
}

#[test]
fn stages_that_import_stages_are_found() {
    let clauses = "/// From: nothing. To: nothing.\n/// Writes: nothing. Reads: nothing.";
    let [a, b] = ["a", "b"].map(|name| stage(name, clauses, ""));
    let b = (b.0, format!("{}\n{}", b.1, b.1.replace("fn b", "fn splat_b")));
    let found =
        |import: &str| broken_together(&[(&a.0, &format!("{import}\n{}", a.1)), (&b.0, &b.1)]);
    for import in [
        "use super::b::b;",
        "use super::{splat, b::{self, c}};",
        "use crate::transport::stages::b;",
        "use crate::transport::{stages::{b::c, d}, tables};",
        "mod tests { use super::super::b::b; }",
        "fn f() { super::b::b() }",
        "use super::splat_b;",
    ] {
        assert!(found(import).contains("imports the stage"), "{import}: {}", found(import));
    }
    for import in ["use super::splat;", "use crate::transport::b;", "mod tests { use super::a; }"] {
        assert_eq!(found(import), "", "{import}");
    }
}

#[test]
fn rules_about_nothing_are_found() {
    let file = Source::new("src/film/mod.rs", "//! Sums.\n");
    let tree = Tree::new(vec![file], floors_of("//! | 2 | `film` | sums |\n"));
    let found = rules_without_ground(&tree, "hecs = 1\n").join("\n");
    for expected in [
        "about src/transport/mis, and no file",
        "about src/transport/stages/, and no file",
        "about src/geometry/, and no file",
        "about the module polarization, and there is none",
        "about the module scene, and there is none",
        "about the crate rayon, which nothing needs",
    ] {
        assert!(found.contains(expected), "{found} lacks {expected}");
    }
    assert!(!found.contains("crate hecs") && !found.contains("module film"), "{found}");
}

#[test]
fn tables_that_lead_nowhere_are_found() {
    let source = "//! `fn nothing`\nimpl Row { fn collect() {} }\npub struct Block;";
    let read = |path: &str| match path {
        "src/a.rs" => Some(source.to_owned()),
        "src/a" => Some(String::new()),
        _ => None,
    };
    let found = |row: &str| check_page("README.md", &format!("# A\n\n{row}\n"), &read).join("\n");
    for row in [
        "| 8 | `t <- t M` | [src/a.rs](src/a.rs) | `Row::collect`, `Block` |",
        "//! | (8) | `nobody` | `src/a.rs` | `collect()` |",
        "| [here](src/a) | `gone` | [there](https://src/gone.rs) |",
        "A line that names `src/gone.rs` is no row.",
    ] {
        assert_eq!(found(row), "", "{row}");
    }
    for (row, expected) in [
        ("| 8 | [src/b.rs](src/b.rs) | |", "README.md:3: there is no src/b.rs"),
        ("//! | 8 | `src/b.rs` | |", "there is no src/b.rs"),
        ("| 8 | `src/a.rs` | `nothing` |", "there is no `nothing` in src/a.rs"),
        ("| 8 | [a](src/a.rs) | `Block::collected` |", "there is no `Block::collected` in"),
        ("| 8 | [a](src/a.rs) | `Column::collect` |", "there is no `Column::collect` in"),
    ] {
        assert!(found(row).contains(expected), "{row}: {:?} lacks {expected:?}", found(row));
    }
}

#[test]
fn what_only_looks_wrong_is_not_found() {
    let innocent = [
        "// use crate::cli::run; todo!()",
        "/* use crate::cli; */",
        "const A: &str = \"crate::cli::run \\\" hecs::World\";",
        "const A: &str = r#\"use crate::cli; \"dbg!(1)\"#;",
        "const A: [char; 3] = ['\"', '\\'', '{'];",
        "fn f<'a>(a: &'a str) -> &'a str { a }",
        "use crate::{image, math::F32s};",
        "#[expect(dead_code, reason = \"so\")]\nfn f() {}",
        "mod tests { use super::super::image; }",
        "fn f() { crate::film::exr::write() }",
        "pub use self::accumulator::Film;",
    ];
    for text in innocent {
        assert_eq!(broken_by("src/film/a.rs", text), "", "{text}");
    }
}
