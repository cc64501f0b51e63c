//! Images: files, comparisons, pictures, pages, and what cameras of polarization see.

mod compare;
mod files;
mod mosaic;
mod pictures;
mod view;
