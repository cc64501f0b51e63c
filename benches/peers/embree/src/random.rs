//! Numbers for scenes and rays, the same in every run.

use std::f32::consts::TAU;

use glam::Vec3;

/// Steele, Lea and Flood 2014, "Fast Splittable Pseudorandom Number Generators".
pub struct Random(pub u64);

impl Random {
    /// In [0, 1).
    pub fn uniform(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1 << 24) as f32
    }

    /// In [low, high).
    pub fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.uniform()
    }

    /// In 0..count.
    pub fn below(&mut self, count: usize) -> usize {
        (self.bits() % count as u64) as usize
    }

    /// A direction about `normal`, as a Lambertian surface scatters.
    pub fn cosine_about(&mut self, normal: Vec3) -> Vec3 {
        let z = self.between(-1.0, 1.0);
        let (sine, cosine) = (TAU * self.uniform()).sin_cos();
        let radius = (1.0 - z * z).sqrt();
        (normal + 0.999 * Vec3::new(radius * cosine, radius * sine, z)).normalize()
    }

    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
}
