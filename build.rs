//! Names the build: renders go on, or are put together, only where they were begun by the same. And
//! has the linker keep functions once that are the same, where it can.

use std::ffi::OsString;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs, io};

/// What an image's bits can depend on, beside these files.
const VARIABLES: [&str; 3] = ["TARGET", "CARGO_CFG_TARGET_FEATURE", "CARGO_PKG_VERSION"];
/// The sources.
const SOURCES: [&str; 3] = ["src", "Cargo.toml", "Cargo.lock"];

fn main() -> io::Result<()> {
    let mut digest = Fnv(Fnv::START);
    for source in SOURCES {
        println!("cargo::rerun-if-changed={source}");
        for file in files_in(Path::new(source))? {
            digest.write_all(file.to_string_lossy().as_bytes())?;
            digest.write_all(&fs::read(file)?)?;
        }
    }
    for name in VARIABLES {
        digest.write_all(env::var(name).unwrap_or_default().as_bytes())?;
    }
    digest.write_all(&compiler().arg("--version").output()?.stdout)?;
    let target = env::var("TARGET").unwrap_or_default();
    println!("cargo::rustc-env=SUNSTONE_BUILD={:016x} for {target}", digest.0);
    if links_with(FOLDED)? {
        println!("cargo::rustc-link-arg-bins={FOLDED}");
    }
    Ok(())
}

fn compiler() -> Command {
    Command::new(env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()))
}

/// Of functions that are the same, which is a twenty-fifth of the program, one is kept: LLD can, which
/// Rust links with on Linux, and mold. Where a function is, nobody asks.
const FOLDED: &str = "-Wl,--icf=all";

/// Whether the linker of this build understands an argument: a program of nothing is linked.
fn links_with(argument: &str) -> io::Result<bool> {
    let variable = |name: &str| env::var(name).unwrap_or_default();
    let folder = PathBuf::from(variable("OUT_DIR"));
    let source = folder.join("nothing.rs");
    fs::write(&source, "fn main() {}")?;
    let mut compiler = compiler();
    compiler.args(["--crate-type", "bin", "--target", &variable("TARGET")]);
    if let Some(linker) = env::var_os("RUSTC_LINKER") {
        let mut option = OsString::from("linker=");
        option.push(linker);
        compiler.arg("-C").arg(option);
    }
    let flags = variable("CARGO_ENCODED_RUSTFLAGS");
    compiler.args(flags.split('\u{1f}').filter(|flag| !flag.is_empty()));
    compiler.arg("-C").arg(format!("link-arg={argument}"));
    compiler.arg("-o").arg(folder.join("nothing")).arg(&source);
    Ok(compiler.output()?.status.success())
}

/// A file, or all files in a folder, in the order of their names.
fn files_in(path: &Path) -> io::Result<Vec<PathBuf>> {
    if !path.is_dir() {
        // A packed crate may come without its lock.
        return Ok(if path.exists() { vec![path.to_owned()] } else { Vec::new() });
    }
    let mut entries: Vec<PathBuf> =
        fs::read_dir(path)?.map(|entry| Ok(entry?.path())).collect::<io::Result<_>>()?;
    entries.sort();
    let files: Vec<Vec<PathBuf>> =
        entries.iter().map(|entry| files_in(entry)).collect::<io::Result<_>>()?;
    Ok(files.concat())
}

/// The hash of Fowler, Noll and Vo: nobody attacks it, and it needs no crate before the build.
struct Fnv(u64);

impl Fnv {
    const START: u64 = 0xcbf2_9ce4_8422_2325;
    const PRIME: u64 = 0x0000_0100_0000_01b3;
}

impl Write for Fnv {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(Self::PRIME);
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
