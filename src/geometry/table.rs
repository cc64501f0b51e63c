//! Tables of trees that may be much larger than the caches.

use std::fmt;
use std::ops::{Deref, DerefMut};

use bytemuck::{Pod, cast_slice, cast_slice_mut, zeroed_vec};
use memmap2::MmapMut;

/// Tables of so many bytes are worth huge pages.
const HUGE_BYTES: usize = 8 << 20;

/// Rows in memory of their own. Large tables ask the system for huge pages: steps through a tree of
/// hundreds of megabytes miss the processor's table of small pages nearly every time, which cost
/// incoherent rays 5 to 15 % among four million triangles.
pub(super) struct Table<T>(Memory<T>);

enum Memory<T> {
    Rows(Vec<T>),
    Pages(MmapMut),
}

impl<T: Pod> Table<T> {
    /// So many rows of zeros.
    pub fn zeroed(len: usize) -> Self {
        let pages = (len * size_of::<T>() >= HUGE_BYTES).then(|| huge_pages(len * size_of::<T>()));
        Self(match pages.flatten() {
            Some(pages) => Memory::Pages(pages),
            None => Memory::Rows(zeroed_vec(len)),
        })
    }
}

/// Zeroed memory in huge pages where there are some, in others where not, none if there is none.
fn huge_pages(bytes: usize) -> Option<MmapMut> {
    let pages = MmapMut::map_anon(bytes).ok()?;
    // A wish: what refuses it serves as well, only slower.
    #[cfg(target_os = "linux")]
    let _ = pages.advise(memmap2::Advice::HugePage);
    Some(pages)
}

impl<T> From<Vec<T>> for Table<T> {
    fn from(rows: Vec<T>) -> Self {
        Self(Memory::Rows(rows))
    }
}

impl<T: Pod> Deref for Table<T> {
    type Target = [T];
    fn deref(&self) -> &[T] {
        match &self.0 {
            Memory::Rows(rows) => rows,
            Memory::Pages(pages) => cast_slice(pages),
        }
    }
}

impl<T: Pod> DerefMut for Table<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        match &mut self.0 {
            Memory::Rows(rows) => rows,
            Memory::Pages(pages) => cast_slice_mut(pages),
        }
    }
}

impl<T: Pod> Clone for Table<T> {
    fn clone(&self) -> Self {
        let mut copy = Self::zeroed(self.len());
        copy.copy_from_slice(self);
        copy
    }
}

impl<T: Pod + PartialEq> PartialEq for Table<T> {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl<T: Pod + fmt::Debug> fmt::Debug for Table<T> {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        (**self).fmt(formatter)
    }
}
