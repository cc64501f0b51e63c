//! Rows grouped by what happens to them next, so that every group is one branch-free loop.

use std::ops::Range;

use crate::scattering::event::{END, Event, Form};

/// The rows that one loop works on: one kind of event, one class of carrier.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// What the rows have met.
    pub event: Event,
    /// Class of their carriers (`carriers`).
    pub class: usize,
    /// The rows.
    pub rows: Range<usize>,
}

impl Part {
    /// Whether the rows meet a depolarizer.
    pub fn is_depolarized(&self) -> bool {
        self.event.form == Form::Depolarizer
    }
}

/// What becomes of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Next {
    /// The place of what it has met among the scene's events; at [`END`] it ends.
    pub event: usize,
    /// The place of its carrier's class.
    pub class: usize,
    /// Whether it goes on from there, or has its last vertex.
    pub goes_on: bool,
}

/// A stable grouping of rows: first those that go on, by event, then carrier class; then those
/// that have their last vertex, likewise.
#[derive(Default)]
pub struct Partition {
    /// For every new row, the old one; rows that end here are missing.
    pub order: Vec<u32>,
    /// The groups, in the order of the new rows; none is empty.
    pub parts: Vec<Part>,
    /// How many of the parts hold rows that go on.
    going_on: usize,
    keys: Vec<u16>,
    counts: Vec<u32>,
}

impl Partition {
    /// Groups the rows `0..rows` by their place in `events` and their class; rows at [`END`] end.
    pub fn group(
        &mut self,
        rows: usize,
        events: &[Event],
        classes: usize,
        next: impl Fn(usize) -> Next,
    ) {
        // Key 0 is that of the rows that end: they are sorted like the others, without a branch
        // that would be guessed wrong, and cut off in the end.
        let of_kind = (events.len() - 1) * classes;
        self.keys.clear();
        self.counts.clear();
        self.counts.resize(2 * of_kind + 1, 0);
        for row in 0..rows {
            let Next { event, class, goes_on } = next(row);
            let key = event.wrapping_sub(1).wrapping_mul(classes).wrapping_add(class + 1);
            let key = key.wrapping_add(if goes_on { 0 } else { of_kind });
            let key = if event == END { 0 } else { key };
            self.counts[key] += 1;
            self.keys.push(key as u16);
        }
        let ended = self.list_parts(events, classes);
        self.order.clear();
        self.order.resize(rows, 0);
        for (row, &key) in self.keys.iter().enumerate() {
            let place = &mut self.counts[key as usize];
            self.order[*place as usize] = row as u32;
            *place += 1;
        }
        self.order.truncate(rows - ended);
    }

    /// Forgets the parts that have their last vertices, and returns how many rows are left.
    pub fn keep_going_on(&mut self) -> usize {
        self.parts.truncate(self.going_on);
        self.parts.last().map_or(0, |part| part.rows.end)
    }

    /// Lets rows go on from specular events only, which come first.
    pub fn end_at_connections(&mut self) {
        let goes_on = |part: &&Part| !part.event.connects();
        self.going_on = self.parts[..self.going_on].iter().take_while(goes_on).count();
    }

    /// The events that rows have met, and their rows; they are contiguous.
    pub fn events(&self) -> impl Iterator<Item = (Event, Range<usize>)> + '_ {
        let of_event = self.parts.chunk_by(|part, next| part.event == next.event);
        of_event.map(|parts| (parts[0].event, parts[0].rows.start..parts[parts.len() - 1].rows.end))
    }

    /// Those that can be connected to.
    pub fn connectable(&self) -> impl Iterator<Item = (Event, Range<usize>)> + '_ {
        self.events().filter(|(event, _)| event.connects())
    }

    /// Turns the counts into the first place of each key, those of key 0 behind all others, lists
    /// the parts, and returns how many rows end.
    fn list_parts(&mut self, events: &[Event], classes: usize) -> usize {
        self.parts.clear();
        self.going_on = 0;
        let mut start = 0;
        let of_kind = (events.len() - 1) * classes;
        for key in 1..self.counts.len() {
            let end = start + self.counts[key];
            if end > start {
                let goes_on = key <= of_kind;
                self.going_on += usize::from(goes_on);
                let key = if goes_on { key - 1 } else { key - 1 - of_kind };
                let event = events[key / classes + 1];
                let class = key % classes;
                self.parts.push(Part { event, class, rows: start as usize..end as usize });
            }
            self.counts[key] = start;
            start = end;
        }
        std::mem::replace(&mut self.counts[0], start) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scattering::Met;
    use crate::scattering::surface::SurfaceKind;

    #[test]
    fn groups_are_stable_and_drop_the_dead() {
        use SurfaceKind::{Absorber, Conductor, Dielectric, Diffuse, ThinDielectric};
        let event = |met, form| Event { met, form, achromatic: true };
        let surface = |kind| event(Met::Surface(kind), Form::Block);
        let kinds = [Absorber, Conductor, Dielectric, ThinDielectric, Diffuse].map(surface);
        let media = [0, 1].map(|row| event(Met::Medium(row), Form::Depolarizer));
        let events = [&kinds[..], &media[..]].concat();
        let rows = [(2, 1), (4, 0), (0, 1), (6, 1), (3, 1), (0, 0), (4, 0), (2, 0), (2, 1), (5, 0)];
        let last = [1, 2, 8, 9];
        let mut partition = Partition::default();
        partition.group(rows.len(), &events, 2, |row| {
            let (event, class) = rows[row];
            Next { event, class, goes_on: !last.contains(&row) }
        });
        assert_eq!(partition.order, [7, 0, 4, 6, 3, 8, 1, 9]);
        let parts: Vec<_> =
            partition.parts.iter().map(|part| (part.event.met, part.class)).collect();
        let [glass, pane, matte] = [Dielectric, ThinDielectric, Diffuse].map(Met::Surface);
        let [fog, mist] = [0, 1].map(Met::Medium);
        let going_on = [(glass, 0), (glass, 1), (pane, 1), (matte, 0), (mist, 1)];
        assert_eq!(parts, [&going_on[..], &[(glass, 1), (matte, 0), (fog, 0)]].concat());
        let found: Vec<_> =
            partition.connectable().map(|(event, rows)| (event.met, rows)).collect();
        assert_eq!(found, [(matte, 3..4), (mist, 4..5), (matte, 6..7), (fog, 7..8)]);
        partition.end_at_connections();
        assert_eq!(partition.keep_going_on(), 3);
        let left: Vec<_> = partition.events().map(|(event, rows)| (event.met, rows)).collect();
        assert_eq!(left, [(glass, 0..2), (pane, 2..3)]);
    }
}
