//! Divides triangles that are large against where they are.
//!
//! Rays keep off a surface by a share of its primitive's largest coordinate, and hits on it are as
//! good as that allows: on a ground of a hundred kilometers, rays would start twenty centimeters
//! above it even where the camera looks from three meters off, and what they meet would be seen
//! from there. Of pieces that are no larger than their distance from what the camera sees, those
//! at hand have small coordinates. A triangle of a million meters becomes some hundreds of them.
//!
//! What is divided are edges, at their middles, and with an edge all triangles that have it, so
//! that what was closed stays closed.

use std::collections::HashSet;

use glam::Vec3;

use super::bodies::place;
use super::primitives::{Triangles, geometric_normal};
use crate::scene::baked::Triangle;
use crate::scene::corners::{Corner, Corners};

/// The largest coordinate of a triangle, relative to its distance from the origin, above which it
/// is divided.
const REACH_MAX: f32 = 32.0;

/// Pieces at most, about; with more, what is left stays as it is.
const PIECES_MAX: usize = 1 << 20;

/// An edge, by the places of its ends.
type Edge = [[u32; 3]; 2];

/// A part of a triangle, or all of it.
#[derive(Clone, Copy)]
struct Piece {
    /// The row of the triangle.
    row: u32,
    corners: [Vec3; 3],
    normals: [Vec3; 3],
    paint: [Corner; 3],
}

/// Divides triangles that reach far beyond `near`, the distance from the origin of what the camera
/// sees, and far beyond their own. Pieces take the places of their triangles; `surfaces` has a row
/// for each.
pub fn divide(triangles: &mut Triangles, surfaces: &mut Vec<u32>, near: f32) {
    let piece = |row: usize| Piece {
        row: row as u32,
        corners: triangles.rows[row].corners,
        normals: triangles.shading_normals[row],
        paint: triangles.paint.row(row),
    };
    let all = 0..triangles.rows.len();
    if !all.clone().any(|row| piece(row).is_large(near)) {
        return;
    }
    // The longest edge of a triangle that is divided is longer than this.
    let divisible = all.map(piece).filter(|piece| piece.longest().1 > near);
    let mut pieces: Vec<Piece> = divisible.collect();
    let before: Vec<u32> = pieces.iter().map(|piece| piece.row).collect();
    while pieces.len() - before.len() < PIECES_MAX {
        let large = pieces.iter().filter(|piece| piece.is_large(near)).map(Piece::longest);
        let large: Vec<(usize, f32, Edge)> = large.collect();
        let Some(least) = large.iter().map(|(_, length, _)| *length).min_by(f32::total_cmp) else {
            break;
        };
        let edges: HashSet<Edge> = large.into_iter().map(|(.., edge)| edge).collect();
        let mut divided = Vec::with_capacity(pieces.len() + 2 * edges.len());
        for piece in pieces {
            piece.divide(&edges, least, &mut divided);
        }
        pieces = divided;
    }
    replace(triangles, surfaces, &before, pieces);
}

/// Puts pieces in the places of the rows that they are of.
fn replace(triangles: &mut Triangles, surfaces: &mut Vec<u32>, of: &[u32], mut pieces: Vec<Piece>) {
    // Of what has no area left nothing can be met.
    pieces.retain(|piece| geometric_normal(piece.corners).is_some());
    let mut pieces = pieces.into_iter().peekable();
    let (rows, normals) = (&triangles.rows, &triangles.shading_normals);
    let paint = Corners::new(triangles.paint.needs());
    let mut result = Triangles { paint, ..Triangles::default() };
    let mut result_surfaces = Vec::with_capacity(surfaces.len());
    let mut of = of.iter().peekable();
    for row in 0..rows.len() {
        if of.next_if(|it| **it as usize == row).is_none() {
            result.rows.push(rows[row]);
            result.shading_normals.push(normals[row]);
            result.paint.push(triangles.paint.row(row));
        }
        while let Some(piece) = pieces.next_if(|piece| piece.row as usize == row) {
            result.rows.push(Triangle { corners: piece.corners });
            result.shading_normals.push(piece.normals);
            result.paint.push(piece.paint);
        }
        result_surfaces.resize(result.rows.len(), surfaces[row]);
    }
    (*triangles, *surfaces) = (result, result_surfaces);
}

impl Piece {
    fn is_large(&self, near: f32) -> bool {
        let [a, b, c] = self.corners;
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let reach = low.abs().max(high.abs()).max_element();
        let distance = low.max(-high).max_element();
        reach > REACH_MAX * distance.max(near)
    }

    /// The longest edge: the corner that it starts at, its length, and its name.
    fn longest(&self) -> (usize, f32, Edge) {
        let lengths = [0, 1, 2].map(|corner| {
            let [from, to, _] = self.from(corner);
            from.0.distance(to.0)
        });
        let longest =
            (1..3).fold(
                0,
                |longest, corner| {
                    if lengths[corner] > lengths[longest] { corner } else { longest }
                },
            );
        (longest, lengths[longest], self.edge(longest))
    }

    /// The corners and what they have, from one on.
    fn from(&self, corner: usize) -> [(Vec3, Vec3, Corner); 3] {
        let rows = [0, 1, 2].map(|next| (corner + next) % 3);
        rows.map(|it| (self.corners[it], self.normals[it], self.paint[it]))
    }

    /// The edge that starts at a corner, the same from either side.
    fn edge(&self, corner: usize) -> Edge {
        let mut ends = [0, 1].map(|next| place(self.corners[(corner + next) % 3]));
        ends.sort_unstable();
        ends
    }

    /// Divides the piece at the middles of those of its edges that are among these, none of which
    /// is shorter than `least`.
    fn divide(self, edges: &HashSet<Edge>, least: f32, divided: &mut Vec<Self>) {
        let is_divided = |corner: &usize| {
            let [from, to, _] = self.from(*corner);
            from.0.distance(to.0) >= least && edges.contains(&self.edge(*corner))
        };
        let Some(corner) = (0..3).find(is_divided) else { return divided.push(self) };
        let [from, to, opposite] = self.from(corner);
        let normal = (from.1 + to.1).normalize_or_zero();
        let middle = (middle(from.0, to.0), normal, from.2.middle(to.2));
        for [a, b, c] in [[from, middle, opposite], [middle, to, opposite]] {
            let (corners, normals) = ([a.0, b.0, c.0], [a.1, b.1, c.1]);
            Self { corners, normals, paint: [a.2, b.2, c.2], ..self }.divide(edges, least, divided);
        }
    }
}

/// The same from either end.
fn middle(one: Vec3, other: Vec3) -> Vec3 {
    (0.5 * (one.as_dvec3() + other.as_dvec3())).as_vec3()
}
