//! Keeps polarized light of paths within the range of numbers.

use crate::math::columns::Channels;
use crate::transport::scale::{excess, scale_row};
use crate::transport::sides::LightSide;

/// Moves what the states of the first `rows` rows have grown by into their throughput, where that
/// is much: they are relative to unpolarized light, and every sheet may double them.
///
/// From: scatter_light. To: trace_closest, scatter_light.
/// Writes: carriers, beta. Reads: rows.
pub fn rescale_light<const N: usize, C: LightSide<N>>(
    carriers: &mut C,
    beta: &mut Channels<N>,
    rows: usize,
) {
    let Some(carriers) = carriers.columns_mut() else { return };
    for row in (0..rows).filter(|&row| carriers.class[row].has_stokes()) {
        for n in 0..N {
            let scale = excess(carriers.stokes[0][n][row]);
            if scale != 1.0 {
                beta[n][row] *= scale;
                scale_row(
                    carriers.stokes.iter_mut().map(|column| &mut column[n]),
                    row,
                    1.0 / scale,
                );
            }
        }
    }
}
