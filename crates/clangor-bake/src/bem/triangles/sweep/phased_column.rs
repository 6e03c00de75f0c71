//! One column of a matrix from a table: weighted sums of the entries, turned by the phase of the distance of
//! their vertices.

use std::f32::consts::TAU;

use glam::DVec3;
use pulp::{Simd, WithSimd};

use crate::bem::triangles::lanes::Lanes;

/// Padding of the rows: the most lanes of any register.
const LANES: usize = 16;

/// Vertices, by coordinate, padded to whole registers.
#[derive(Clone, Debug)]
pub(super) struct Points([Vec<f32>; 3]);

impl Points {
    pub(super) fn new(vertices: &[DVec3]) -> Self {
        let stride = stride(vertices.len());
        Points(std::array::from_fn(|c| {
            let mut padded: Vec<f32> = vertices.iter().map(|v| v[c] as f32).collect();
            padded.resize(stride, 0.0);
            padded
        }))
    }
}

/// Rows with their padding.
pub(super) fn stride(rows: usize) -> usize {
    rows.next_multiple_of(LANES)
}

/// e^{−ikr} Σ w (re + i im), r from one point to all, as real and then imaginary parts.
pub(super) struct PhasedColumn<'a> {
    pub(super) k: f32,
    pub(super) from: DVec3,
    pub(super) points: &'a Points,
    /// Weights, and real and then imaginary parts.
    pub(super) terms: &'a [(f32, &'a [f32])],
    pub(super) out: &'a mut [f32],
}

impl PhasedColumn<'_> {
    pub(super) fn compute(self) {
        pulp::Arch::new().dispatch(self);
    }
}

impl WithSimd for PhasedColumn<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { k, from, points: Points(points), terms, out } = self;
        let stride = points[0].len();
        let (x, y, z) =
            (S::as_simd_f32s(&points[0]).0, S::as_simd_f32s(&points[1]).0, S::as_simd_f32s(&points[2]).0);
        let splat = |value: f32| Lanes::splat(simd, value);
        let from = [splat(from.x as f32), splat(from.y as f32), splat(from.z as f32)];
        let (rate, least) = (splat(k / TAU), splat(1e-12));
        let (out_re, out_im) = out.split_at_mut(stride);
        let (out_re, out_im) = (S::as_mut_simd_f32s(out_re).0, S::as_mut_simd_f32s(out_im).0);
        for i in 0..x.len() {
            let d = [
                Lanes::of(simd, x[i]) - from[0],
                Lanes::of(simd, y[i]) - from[1],
                Lanes::of(simd, z[i]) - from[2],
            ];
            let square = d[0].times_plus(d[0], d[1].times_plus(d[1], d[2] * d[2])).max(least);
            let (sine, cosine) = (square * square.inverse_root() * rate).turn();
            let (mut re, mut im) = (splat(0.0), splat(0.0));
            for (weight, values) in terms {
                let (of_re, of_im) = values.split_at(stride);
                let weight = splat(*weight);
                re = weight.times_plus(Lanes::of(simd, S::as_simd_f32s(of_re).0[i]), re);
                im = weight.times_plus(Lanes::of(simd, S::as_simd_f32s(of_im).0[i]), im);
            }
            out_re[i] = re.times_plus(cosine, im * sine).register();
            out_im[i] = (im * cosine).less(re, sine).register();
        }
    }
}
