//! What the race found, as text and as JSON.

use std::fmt;

use serde_json::{Value, json};

/// Both trees of a scene: Sunstone's first, Embree's second.
pub struct Built {
    pub scene: &'static str,
    pub triangles: usize,
    pub seconds: [f64; 2],
    /// Of Sunstone's tree and the triangles that it was made from.
    pub bytes: usize,
}

/// A set of rays, traced by both in every round.
pub struct Raced {
    pub scene: &'static str,
    pub set: &'static str,
    /// Per ray; Sunstone's first, Embree's second.
    pub nanoseconds: Vec<[f64; 2]>,
    /// Rays whose results differ.
    pub differing: usize,
}

#[derive(Default)]
pub struct Report {
    pub built: Vec<Built>,
    pub raced: Vec<Raced>,
}

impl Raced {
    /// Median of the rounds' ratios; above 1 Sunstone is faster.
    fn ratio(&self) -> f64 {
        median(self.nanoseconds.iter().map(|[ours, theirs]| theirs / ours))
    }

    fn median(&self, who: usize) -> f64 {
        median(self.nanoseconds.iter().map(|both| both[who]))
    }

    fn is_coherent(&self) -> bool {
        self.set.starts_with("coherent")
    }
}

impl Report {
    /// Geometric mean and smallest of the ratios.
    fn summary(&self, coherent: bool) -> [f64; 2] {
        let raced = self.raced.iter().filter(|raced| raced.is_coherent() == coherent);
        let ratios: Vec<f64> = raced.map(Raced::ratio).collect();
        let mean = ratios.iter().map(|ratio| ratio.ln()).sum::<f64>() / ratios.len() as f64;
        [mean.exp(), ratios.iter().copied().fold(f64::INFINITY, f64::min)]
    }

    pub fn to_json(&self) -> Value {
        let built = self.built.iter().map(|built| {
            json!({
                "scene": built.scene,
                "triangles": built.triangles,
                "seconds": { "sunstone": built.seconds[0], "embree": built.seconds[1] },
                "bytes_per_triangle": built.bytes as f64 / built.triangles as f64,
            })
        });
        let raced = self.raced.iter().map(|raced| {
            json!({
                "scene": raced.scene,
                "set": raced.set,
                "nanoseconds": { "sunstone": raced.median(0), "embree": raced.median(1) },
                "ratio": raced.ratio(),
                "differing": raced.differing,
            })
        });
        let summary = |coherent| {
            let [mean, worst] = self.summary(coherent);
            json!({ "geometric_mean": mean, "worst": worst })
        };
        json!({
            "built": built.collect::<Vec<_>>(),
            "raced": raced.collect::<Vec<_>>(),
            "single": summary(false),
            "coherent": summary(true),
        })
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{:10} {:>9} {:>8} {:>8} {:>6} {:>10}",
            "scene", "triangles", "build s", "Embree", "ratio", "B/triangle"
        )?;
        for built in &self.built {
            let [ours, theirs] = built.seconds;
            let bytes = built.bytes as f64 / built.triangles as f64;
            writeln!(
                f,
                "{:10} {:>9} {ours:8.3} {theirs:8.3} {:6.2} {bytes:10.0}",
                built.scene,
                built.triangles,
                ours / theirs
            )?;
        }
        writeln!(
            f,
            "\n{:10} {:16} {:>8} {:>8} {:>6} {:>9}",
            "scene", "rays", "ns", "Embree", "times", "differing"
        )?;
        for raced in &self.raced {
            let [ours, theirs] = [0, 1].map(|who| raced.median(who));
            writeln!(
                f,
                "{:10} {:16} {ours:8.1} {theirs:8.1} {:6.2} {:>9}",
                raced.scene,
                raced.set,
                raced.ratio(),
                raced.differing
            )?;
        }
        let [single, coherent] = [false, true].map(|coherent| self.summary(coherent));
        writeln!(
            f,
            "\nrtcIntersect1, rtcOccluded1: geometric mean {:.2} (must 1.2, aim 1.4), \
            worst {:.2} (must 0.9, aim 1.0)",
            single[0], single[1]
        )?;
        write!(
            f,
            "rtcIntersect16, coherent: geometric mean {:.2} (must 0.6, aim 1.0), worst {:.2}",
            coherent[0], coherent[1]
        )
    }
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    if values.len() % 2 == 1 { values[middle] } else { values[middle - 1].midpoint(values[middle]) }
}
