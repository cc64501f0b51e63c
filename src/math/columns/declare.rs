//! The declaration of columns.

/// Declares columns: a struct of them with [`Columns`], so that no operation can forget one.
///
/// ```text
/// columns! {
///     /// Photons on their way.
///     pub struct PhotonColumns<const N: usize> of Photon {
///         /// Where.
///         pub position: [Column; 3],
///         /// The medium about it.
///         pub inside: Vec<u32> = NONE,
///         /// Power per wavelength.
///         pub power: Channels<N>,
///     }
/// }
/// ```
///
/// A column may name its fill; else it is zero. `of Photon` declares what one row holds, so that
/// rows can be read and set (see [`Rows`]) and whoever does must mention every column.
///
/// `table` in the place of `struct` adds `len`, the number of rows in use, and what follows from
/// it: `reserve`, `append`, `take`, and with `of` also `push_row`. A table may have fields `beside`
/// its columns, each with what it starts with.
macro_rules! columns {
    ($(#[$meta:meta])* $vis:vis struct $name:ident $(<const $n:ident: usize>)?
        { $($body:tt)* }) => {
        $crate::math::columns::columns! { @struct
            [$(#[$meta])* $vis struct $name $(<const $n: usize>)?] { $($body)* } {}
        }
        $crate::math::columns::columns! { @columns $name [$($n)?] { $($body)* } {} }
    };
    ($(#[$meta:meta])* $vis:vis struct $name:ident $(<const $n:ident: usize>)? of $row:ident
        { $($body:tt)* }) => {
        $crate::math::columns::columns! {
            $(#[$meta])* $vis struct $name $(<const $n: usize>)? { $($body)* }
        }
        $crate::math::columns::columns! { @rows $vis $row $name [$($n)?] { $($body)* } }
    };
    ($(#[$meta:meta])* $vis:vis table $name:ident $(<const $n:ident: usize>)? { $($body:tt)* }
        $(beside { $($beside:tt)* })?) => {
        $crate::math::columns::columns! { @struct
            [$(#[$meta])* $vis struct $name $(<const $n: usize>)?] { $($body)* } {
                /// Number of rows in use.
                $vis len: usize = 0,
                $($($beside)*)?
            }
        }
        $crate::math::columns::columns! { @columns $name [$($n)?] { $($body)* } {
            $vis len: usize = 0,
            $($($beside)*)?
        } }
        $crate::math::columns::columns! { @table $vis $name [$($n)?] }
    };
    ($(#[$meta:meta])* $vis:vis table $name:ident $(<const $n:ident: usize>)? of $row:ident
        { $($body:tt)* } $(beside $beside:tt)?) => {
        $crate::math::columns::columns! {
            $(#[$meta])* $vis table $name $(<const $n: usize>)? { $($body)* } $(beside $beside)?
        }
        $crate::math::columns::columns! { @rows $vis $row $name [$($n)?] { $($body)* } }
        $crate::math::columns::columns! { @push $vis $row $name [$($n)?] }
    };

    (@fill $type:ty) => { <$type as $crate::math::columns::Columns>::ZERO };
    (@fill $type:ty, $fill:expr) => { $fill };

    (@struct [$($head:tt)*]
        { $($(#[$meta:meta])* $vis:vis $column:ident: $type:ty $(= $fill:expr)?),* $(,)? }
        { $($(#[$of:meta])* $seen:vis $beside:ident: $kind:ty = $start:expr),* $(,)? }
    ) => {
        $($head)* {
            $($(#[$of])* $seen $beside: $kind,)*
            $($(#[$meta])* $vis $column: $type,)*
        }
    };

    (@columns $name:ident [$($n:ident)?]
        { $($(#[$meta:meta])* $vis:vis $column:ident: $type:ty $(= $fill:expr)?),* $(,)? }
        { $($(#[$of:meta])* $seen:vis $beside:ident: $kind:ty = $start:expr),* $(,)? }
    ) => {
        impl $(<const $n: usize>)? $crate::math::columns::Columns for $name $(<$n>)? {
            type Fill = ();
            const ZERO: () = ();

            fn filled(rows: usize, (): ()) -> Self {
                Self {
                    $($beside: $start,)*
                    $($column: <$type as $crate::math::columns::Columns>::filled(
                        rows,
                        $crate::math::columns::columns!(@fill $type $(, $fill)?),
                    ),)*
                }
            }

            fn absent() -> Self {
                Self {
                    $($beside: $start,)*
                    $($column: $crate::math::columns::Columns::absent(),)*
                }
            }

            fn lengthen(&mut self, rows: usize, (): ()) {
                $($crate::math::columns::Columns::lengthen(
                    &mut self.$column,
                    rows,
                    $crate::math::columns::columns!(@fill $type $(, $fill)?),
                );)*
            }

            #[inline(always)]
            fn room(&self) -> usize {
                let mut room = 0;
                $(if room == 0 {
                    room = $crate::math::columns::Columns::room(&self.$column);
                })*
                room
            }

            fn bytes_per_row(&self) -> usize {
                0 $(+ $crate::math::columns::Columns::bytes_per_row(&self.$column))*
            }

            #[inline(always)]
            fn each_with(&mut self, from: &Self, work: &impl $crate::math::columns::PairWork) {
                $($crate::math::columns::Columns::each_with(
                    &mut self.$column,
                    &from.$column,
                    work,
                );)*
            }

            fn each(&mut self, work: &impl $crate::math::columns::ColumnWork) {
                $($crate::math::columns::Columns::each(&mut self.$column, work);)*
            }
        }

        impl $(<const $n: usize>)? $name $(<$n>)? {
            /// Room for `capacity` rows.
            pub fn new(capacity: usize) -> Self {
                $crate::math::columns::Columns::with_room(capacity)
            }
        }
    };

    (@rows $seen:vis $row:ident $name:ident [$($n:ident)?]
        { $($(#[$meta:meta])* $vis:vis $column:ident: $type:ty $(= $fill:expr)?),* $(,)? }
    ) => {
        #[doc = concat!("What a row of [`", stringify!($name), "`] holds.")]
        #[derive(Clone, Copy, Debug, PartialEq)]
        $seen struct $row $(<const $n: usize>)? {
            $($(#[$meta])* $vis $column: <$type as $crate::math::columns::Rows>::Row,)*
        }

        impl $(<const $n: usize>)? $crate::math::columns::Rows for $name $(<$n>)? {
            type Row = $row $(<$n>)?;

            #[inline(always)]
            fn get(&self, row: usize) -> Self::Row {
                $row { $($column: $crate::math::columns::Rows::get(&self.$column, row),)* }
            }

            #[inline(always)]
            fn set(&mut self, row: usize, value: Self::Row) {
                $($crate::math::columns::Rows::set(&mut self.$column, row, value.$column);)*
            }
        }
    };

    (@table $vis:vis $name:ident [$($n:ident)?]) => {
        impl $(<const $n: usize>)? $name $(<$n>)? {
            /// Makes room for `more` rows after `len`.
            #[inline(always)]
            $vis fn reserve(&mut self, more: usize) {
                let needed = self.len + more + $crate::math::LANES;
                if needed > $crate::math::columns::Columns::room(self) {
                    self.grow(needed);
                }
            }

            #[cold]
            fn grow(&mut self, needed: usize) {
                let rows = needed.max(2 * $crate::math::columns::Columns::room(self));
                $crate::math::columns::Columns::lengthen(self, rows, ());
            }

            /// Appends all rows of another table; what is beside the columns stays.
            $vis fn append(&mut self, from: &Self) {
                self.reserve(from.len);
                $crate::math::columns::Columns::copy_rows(self, from, 0..from.len, self.len);
                self.len += from.len;
            }

            /// Takes the rows `order` of another table in the place of all rows; what is beside
            /// the columns stays.
            $vis fn take(&mut self, from: &Self, order: &[u32]) {
                self.len = 0;
                self.reserve(order.len());
                $crate::math::columns::Columns::take_rows(self, from, order, 0);
                self.len = order.len();
            }
        }
    };

    (@push $vis:vis $row:ident $name:ident [$($n:ident)?]) => {
        impl $(<const $n: usize>)? $name $(<$n>)? {
            /// Appends a row.
            #[inline(always)]
            $vis fn push_row(&mut self, row: $row $(<$n>)?) {
                self.reserve(1);
                $crate::math::columns::Rows::set(self, self.len, row);
                self.len += 1;
            }
        }
    };
}

pub(crate) use columns;

#[cfg(test)]
mod tests {
    use std::ops::Range;

    use crate::math::LANES;
    use crate::math::columns::*;

    columns! {
        /// A group.
        #[derive(Clone, Debug, PartialEq)]
        struct Inner of InnerRow {
            far: Column = f32::INFINITY,
            vector: [Column; 3],
        }
    }

    columns! {
        /// Every kind of column there is.
        table Everything<const N: usize> of Anything {
            float: Column,
            channels: Channels<N>,
            identifier: Vec<u32>,
            medium: Vec<u32> = 7,
            packed: [[Vec<i16>; N]; 3],
            row: Vec<[f32; N]>,
            inner: Inner,
            inners: [Inner; 2],
        } beside {
            notes: Vec<u32> = vec![1, 2, 3],
        }
    }

    columns! {
        /// Never pushed to.
        table Packets {
            float: Column,
        }
    }

    /// A row whose values are all different from each other's and from other rows'.
    fn anything(row: usize) -> Anything<2> {
        let mut next = 100 * row as u32;
        let mut count = || {
            next += 1;
            next
        };
        let mut float = || count() as f32;
        let mut inner = || InnerRow { far: float(), vector: [float(), float(), float()] };
        let (first, second, third) = (inner(), inner(), inner());
        Anything {
            inner: first,
            inners: [second, third],
            float: float(),
            channels: [float(), float()],
            row: [float(), float()],
            identifier: count(),
            medium: count(),
            packed: [0; 3].map(|_| [0; 2].map(|_| count() as i16)),
        }
    }

    fn at(table: &Everything<2>, row: usize) -> Anything<2> {
        let inner = |inner: &Inner| InnerRow {
            far: inner.far[row],
            vector: inner.vector.each_ref().map(|column| column[row]),
        };
        Anything {
            float: table.float[row],
            channels: table.channels.each_ref().map(|column| column[row]),
            identifier: table.identifier[row],
            medium: table.medium[row],
            packed: table.packed.each_ref().map(|all| all.each_ref().map(|column| column[row])),
            row: table.row[row],
            inner: inner(&table.inner),
            inners: table.inners.each_ref().map(inner),
        }
    }

    fn filled_with(rows: Range<usize>) -> Everything<2> {
        let mut table = Everything::new(3);
        rows.for_each(|row| table.push_row(anything(row)));
        table
    }

    fn lengths(table: &Everything<2>) -> Vec<usize> {
        let inner = |inner: &Inner| {
            let mut lengths = vec![inner.far.len()];
            lengths.extend(inner.vector.iter().map(Vec::len));
            lengths
        };
        let mut lengths = vec![table.float.len(), table.identifier.len(), table.medium.len()];
        lengths.extend(table.channels.iter().map(Vec::len));
        lengths.extend(table.packed.iter().flatten().map(Vec::len));
        lengths.push(table.row.len());
        lengths.extend(inner(&table.inner));
        lengths.extend(table.inners.iter().flat_map(inner));
        lengths
    }

    #[test]
    fn new_columns_are_padded_and_filled() {
        let table = Everything::<2>::new(5);
        assert!(lengths(&table).iter().all(|&rows| rows == 5 + LANES));
        assert_eq!((table.len, table.room()), (0, 5 + LANES));
        let none = InnerRow { far: f32::INFINITY, vector: [0.0; 3] };
        let fill = Anything {
            float: 0.0,
            channels: [0.0; 2],
            identifier: 0,
            medium: 7,
            packed: [[0; 2]; 3],
            row: [0.0; 2],
            inner: none,
            inners: [none; 2],
        };
        assert!((0..5 + LANES).all(|row| at(&table, row) == fill));
        assert_eq!(table.notes, [1, 2, 3]);
    }

    #[test]
    fn pushed_rows_survive_growing_in_every_column() {
        let table = filled_with(0..50);
        assert_eq!(table.len, 50);
        assert!((0..50).all(|row| at(&table, row) == anything(row)));
        let lengths = lengths(&table);
        assert!(lengths.iter().all(|&rows| rows == lengths[0] && rows >= 50 + LANES));
        let padding = at(&table, table.room() - 1);
        assert_eq!((padding.medium, padding.inner.far), (7, f32::INFINITY));
    }

    #[test]
    fn tables_are_appended_in_every_column() {
        let (mut table, more) = (filled_with(0..9), filled_with(9..40));
        table.append(&more);
        assert_eq!(table.len, 40);
        assert!((0..40).all(|row| at(&table, row) == anything(row)));
        assert!(lengths(&table).iter().all(|&rows| rows >= 40 + LANES));
    }

    #[test]
    fn rows_are_taken_by_an_order_in_every_column() {
        let from = filled_with(0..30);
        let order = [4, 29, 0, 0, 17, 3, 28, 12, 11, 10, 9];
        let mut table = Everything::new(0);
        table.take(&from, &order);
        assert_eq!(table.len, order.len());
        for (row, &old) in order.iter().enumerate() {
            assert_eq!(at(&table, row), anything(old as usize));
        }
        table.take_rows(&from, &order[..2], 5);
        assert_eq!([5, 6, 7].map(|row| at(&table, row)), [4, 29, 12].map(anything));
    }

    #[test]
    fn absent_columns_stay_absent() {
        let from = filled_with(0..20);
        let mut table = Everything::<2>::new(0);
        let all = table.bytes_per_row();
        assert_eq!(all, 4 * (1 + 2 + 1 + 1 + 2 + 3 * 4) + 2 * 6);
        table.packed = Columns::absent();
        table.inner.far = Columns::absent();
        table.float = Columns::absent();
        assert_eq!(table.bytes_per_row(), all - 12 - 4 - 4);
        assert_eq!(table.room(), LANES, "that of the first column there is");
        table.append(&from);
        table.take(&from, &[3, 2, 1]);
        assert!(table.packed.iter().flatten().all(Vec::is_empty));
        assert!(table.inner.far.is_empty() && table.float.is_empty());
        assert_eq!(table.row[..3], [3, 2, 1].map(|row| anything(row).row));
        assert_eq!((Inner::new(0).room(), Inner::absent().room()), (LANES, 0));
    }

    #[test]
    fn tables_without_rows_of_their_own_reserve() {
        let mut packets = Packets::new(0);
        packets.reserve(LANES + 1);
        assert_eq!(packets.float.len(), 2 * LANES + 1);
        packets.reserve(LANES);
        assert_eq!(packets.room(), 2 * LANES + 1);
        (packets.float[0], packets.len) = (1.5, 1);
        let mut more = Packets::new(0);
        more.append(&packets);
        more.append(&packets);
        packets.take(&more, &[1, 0, 1]);
        assert_eq!((packets.len, &packets.float[..3]), (3, &[1.5; 3][..]));
    }
}
