//! Floor 8: files, pictures and reports.
