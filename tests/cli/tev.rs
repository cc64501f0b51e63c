//! `--tev`: what arrives at a viewer that knows the protocol of tev and nothing of the program.

use std::collections::BTreeMap;
use std::io::{ErrorKind, Read};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use sunstone::StokesImage;

use crate::program::{Run, folder, names_in, scene, sunstone};

/// What a viewer has been shown.
#[derive(Default)]
struct Shown {
    name: String,
    width: usize,
    height: usize,
    /// By name.
    channels: BTreeMap<String, Vec<f32>>,
    /// Pixels that came, with those that came again.
    pixels: usize,
}

/// Reads what tev reads (its `Ipc.cpp`): little-endian numbers, strings that end with a zero.
struct Packet<'a>(&'a [u8]);

impl Packet<'_> {
    fn take<const N: usize>(&mut self) -> [u8; N] {
        let (taken, rest) = self.0.split_first_chunk().expect("the packet goes on");
        self.0 = rest;
        *taken
    }

    fn number(&mut self) -> usize {
        i32::from_le_bytes(self.take()).try_into().expect("not below zero")
    }

    fn long(&mut self) -> usize {
        i64::from_le_bytes(self.take()).try_into().expect("not below zero")
    }

    fn text(&mut self) -> String {
        let end = self.0.iter().position(|&byte| byte == 0).expect("a zero");
        let text = String::from_utf8(self.0[..end].to_vec()).expect("it is text");
        self.0 = &self.0[end + 1..];
        text
    }
}

impl Shown {
    /// Acts on a packet, its length left out.
    fn hear(&mut self, packet: &[u8]) {
        let mut packet = Packet(packet);
        let [kind, focus] = packet.take();
        let name = packet.text();
        match kind {
            4 => {
                assert!(self.channels.is_empty() && focus == 1, "one image, seen when it comes");
                (self.name, self.width, self.height) = (name, packet.number(), packet.number());
                let count = packet.number();
                let black = vec![0.0; self.width * self.height];
                self.channels = (0..count).map(|_| (packet.text(), black.clone())).collect();
                assert_eq!(self.channels.len(), count);
            }
            6 => {
                assert_eq!((&name, focus), (&self.name, 0));
                let count = packet.number();
                let names: Vec<String> = (0..count).map(|_| packet.text()).collect();
                let [x, y, width, height] = [(); 4].map(|()| packet.number());
                let offsets: Vec<usize> = (0..count).map(|_| packet.long()).collect();
                let strides: Vec<usize> = (0..count).map(|_| packet.long()).collect();
                let values = std::mem::take(&mut packet.0);
                assert!(values.len() <= 1 << 20, "more than tev has room for at first");
                for ((name, offset), stride) in names.iter().zip(offsets).zip(strides) {
                    let plane = self.channels.get_mut(name).expect("a channel of the image");
                    for pixel in 0..width * height {
                        let bytes = &values[4 * (offset + stride * pixel)..][..4];
                        let place = (y + pixel / width) * self.width + x + pixel % width;
                        plane[place] = f32::from_le_bytes(bytes.try_into().unwrap());
                    }
                }
                self.pixels += width * height;
            }
            _ => panic!("a packet of kind {kind}"),
        }
        assert!(packet.0.is_empty(), "{} bytes too many", packet.0.len());
    }

    /// How often the whole image came.
    fn images(&self) -> usize {
        assert_eq!(self.pixels % (self.width * self.height), 0, "a part of an image");
        self.pixels / (self.width * self.height)
    }

    fn plane(&self, name: &str) -> &[f32] {
        &self.channels[name]
    }
}

fn next_packet(stream: &mut TcpStream) -> Option<Vec<u8>> {
    let mut length = [0; 4];
    match stream.read_exact(&mut length) {
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => return None,
        read => read.unwrap(),
    }
    let mut packet = vec![0; u32::from_le_bytes(length) as usize - 4];
    stream.read_exact(&mut packet).unwrap();
    Some(packet)
}

/// A viewer that takes `packets` at most; its address and what it has been shown.
fn viewer(packets: usize) -> (String, JoinHandle<Shown>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let watch = move || {
        let (mut stream, _) = listener.accept().unwrap();
        let mut shown = Shown::default();
        for _ in 0..packets {
            let Some(packet) = next_packet(&mut stream) else { break };
            shown.hear(&packet);
        }
        shown
    };
    (address, thread::spawn(watch))
}

fn render(here: &Path, address: &str, options: &str) -> Run {
    let scene = scene("cornell");
    let mut arguments = vec!["render", &scene, "-o", "a b.exr", "--tev", address, "--quiet"];
    arguments.extend(options.split_whitespace());
    sunstone(here, &arguments)
}

fn image_in(here: &Path) -> StokesImage {
    StokesImage::load(&here.join("a b.exr")).unwrap()
}

/// S0 to the bit, degree and angle by the formulas of the README.
fn assert_is_shown(image: &StokesImage, shown: &Shown) {
    assert_eq!([shown.width, shown.height], [image.width, image.height]);
    let mut names = Vec::new();
    for (channel, name) in image.channel_names().iter().enumerate() {
        let is_mono = image.channel_names().len() == 1;
        names.push(if is_mono { "S0.Y".to_owned() } else { format!("S0.{name}") });
        assert!(shown.plane(&names[channel]) == image.plane(0, channel), "S0 of {name}");
    }
    if image.components == 4 {
        names.extend(["degree.Y", "angle.Y"].map(String::from));
        let weights: &[f64] = if names.len() == 3 { &[1.0] } else { &[0.2126, 0.7152, 0.0722] };
        let mut polarized = 0;
        for pixel in 0..image.width * image.height {
            let [s0, s1, s2, s3] = [0, 1, 2, 3].map(|component| {
                let value = |channel| f64::from(image.plane(component, channel)[pixel]);
                weights.iter().enumerate().map(|(it, weight)| weight * value(it)).sum::<f64>()
            });
            let degree = if s0 > 0.0 { (s1 * s1 + s2 * s2 + s3 * s3).sqrt() / s0 } else { 0.0 };
            assert!((f64::from(shown.plane("degree.Y")[pixel]) - degree).abs() < 1e-5);
            if degree > 0.01 {
                let angle = (s2.atan2(s1) / 2.0).to_degrees().rem_euclid(180.0);
                let off = 180.0 * f64::from(shown.plane("angle.Y")[pixel]) - angle;
                assert!(off.abs() < 0.1 || off.abs() > 179.9, "pixel {pixel}: {off} degrees");
                polarized += 1;
            }
        }
        assert!(polarized > 10 || image.height == 1, "{polarized}");
    }
    names.sort();
    assert_eq!(shown.channels.keys().collect::<Vec<_>>(), names.iter().collect::<Vec<_>>());
}

#[test]
fn the_last_image_is_the_one_in_the_file() {
    for (name, options) in [
        ("rgb", "--width 40 --height 24 --spp 40 --integrator path"),
        ("variance", "--width 24 --spp 32 --integrator path --variance"),
        ("mono", "--width 24 --spp 4 --color mono --integrator bdpt"),
        ("scalar", "--width 24 --spp 4 --mode scalar --integrator path"),
        ("intensity", "--width 24 --spp 4 --mode intensity --color mono --integrator path"),
        ("wide", "--width 30000 --height 1 --spp 1 --integrator path"),
    ] {
        let here = folder(&format!("tev-{name}"));
        let (address, shown) = viewer(usize::MAX);
        let run = render(&here, &address, options).done();
        let shown = shown.join().unwrap();
        assert_eq!((shown.name.as_str(), run.stderr.as_str()), ("a b.exr", ""), "{name}");
        assert_is_shown(&image_in(&here), &shown);
    }
}

/// Seconds of many waves: an image at once, then about one a second, and the last.
#[test]
fn images_come_about_once_a_second() {
    let here = folder("tev-often");
    let (address, shown) = viewer(usize::MAX);
    let options = "--width 16 --spp 1000000 --time-limit 3.5 --integrator path";
    render(&here, &address, options).done();
    let shown = shown.join().unwrap();
    assert!((3..=6).contains(&shown.images()), "{}", shown.images());
    assert_is_shown(&image_in(&here), &shown);
}

#[test]
fn a_viewer_that_is_not_there_is_an_error_before_the_render() {
    let here = folder("tev-missing");
    let nobody = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string();
    let start = Instant::now();
    let run = render(&here, &nobody, "--spp 1000000");
    assert_eq!(run.code, 1, "{}", run.stderr);
    assert!(run.stderr.contains(&format!("no tev answers at {nobody}: ")), "{}", run.stderr);
    for address in ["here", "14158", ":14158", "here:many", "here:70000", "", "here:"] {
        let run = render(&here, address, "--spp 1000000");
        assert_eq!(run.code, 2, "{address}: {}", run.stderr);
        assert!(run.stderr.contains("HOST:PORT"), "{address}: {}", run.stderr);
    }
    let run = render(&here, "no.such.name.invalid:1", "--spp 1000000");
    assert_eq!(run.code, 1, "{}", run.stderr);
    assert!(run.stderr.contains("at no.such.name.invalid:1: "), "{}", run.stderr);
    assert!(start.elapsed() < Duration::from_secs(60));
    assert!(names_in(&here).is_empty());
}

/// It is said once, and the image is as without.
#[test]
fn a_viewer_that_goes_away_stops_no_render() {
    let here = folder("tev-gone");
    let (address, shown) = viewer(2);
    let options = "--width 16 --spp 1000000 --time-limit 3.5 --integrator path";
    let run = render(&here, &address, options).done();
    assert_eq!(shown.join().unwrap().images(), 1);
    assert_eq!(run.stderr.matches("warning: ").count(), 1, "{}", run.stderr);
    assert!(run.stderr.contains(&format!("warning: tev at {address} is gone (")), "{}", run.stderr);
    assert_eq!(image_in(&here).width, 16);
}

/// It takes the connection and then nothing: more than the system keeps for it is not sent.
#[test]
fn a_viewer_that_hangs_stops_no_render() {
    let here = folder("tev-hangs");
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let start = Instant::now();
    let options = "--width 900 --height 900 --spp 1 --integrator path --max-path-length 1";
    let run = render(&here, &address, options).done();
    assert!(start.elapsed() < Duration::from_secs(60), "{:?}", start.elapsed());
    let words = format!("warning: tev at {address} has taken nothing for 5 seconds");
    assert!(run.stderr.contains(&words), "{}", run.stderr);
    assert_eq!(run.stderr.matches("warning: tev").count(), 1, "{}", run.stderr);
    assert_eq!(image_in(&here).width, 900);
}
