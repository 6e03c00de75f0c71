//! Kernel of the far pairs: integrates one test triangle against the source triangles in the lanes of a
//! register, in both directions.
//!
//! ```text
//! G = e^{−ikr}/(4πr),    −(dG/dr)/r = (1/r + ik) G/r
//! ```
//!
//! Everything is inlined into the loop that `pulp` compiles for each instruction set.

#![allow(
    clippy::needless_range_loop,
    reason = "loops over lanes, several arrays at one index, that become vector instructions"
)]

use std::f32::consts::{PI, TAU};

use clangor_core::sound_model::acceleration::field::RIGID_DOFS;
use pulp::Simd;

use super::geometry::Test;
use super::layout::{AREA, CURL, GROUP, LOADS, NORMAL, POINT, SUMS, TURNING};
use crate::bem::triangles::lanes::Lanes;

/// One test triangle against the sources in one register.
pub(super) struct PairLanes<'a, S: Simd> {
    pub(super) simd: S,
    pub(super) k: Lanes<S>,
    pub(super) coupling: Lanes<S>,
    pub(super) test: &'a Test,
    pub(super) sources: &'a [S::f32s],
    pub(super) part: usize,
    pub(super) parts: usize,
}

/// A complex number per lane.
type Complexes<S> = [Lanes<S>; 2];

/// Unit normals of both triangles.
struct Normals<S: Simd> {
    test: [Lanes<S>; 3],
    source: [Lanes<S>; 3],
}

/// Sums of one pair over its nine pairs of points.
struct PairIntegrals<S: Simd> {
    /// Rows: shape functions of the test; columns: points of the source.
    forward: [[Complexes<S>; 3]; 3],
    /// The same for the source as the test function.
    backward: [[Complexes<S>; 3]; 3],
    /// ΣG.
    total: Complexes<S>,
    /// Loads of the shape functions of the test.
    load_total: [Complexes<S>; 3],
    /// The same times y × n, by shape function and component.
    load_turning: [[Complexes<S>; 3]; 3],
    /// Loads at the points of the source.
    back_total: [Complexes<S>; 3],
    /// The same times x × n, by component and point.
    back_turning: [[Complexes<S>; 3]; 3],
}

impl<S: Simd> PairIntegrals<S> {
    #[inline(always)]
    fn zero(zero: Lanes<S>) -> Self {
        PairIntegrals {
            forward: [[[zero; 2]; 3]; 3],
            backward: [[[zero; 2]; 3]; 3],
            total: [zero; 2],
            load_total: [[zero; 2]; 3],
            load_turning: [[[zero; 2]; 3]; 3],
            back_total: [[zero; 2]; 3],
            back_turning: [[[zero; 2]; 3]; 3],
        }
    }

    /// Adds the load of a point of the test, with x × n there, to that of point `b` of the source.
    #[inline(always)]
    fn add_back_load(&mut self, b: usize, load: Complexes<S>, turning_test: &[Lanes<S>; 3]) {
        for z in 0..2 {
            self.back_total[b][z] = self.back_total[b][z] + load[z];
            for c in 0..3 {
                self.back_turning[c][b][z] = load[z].times_plus(turning_test[c], self.back_turning[c][b][z]);
            }
        }
    }

    /// Adds the loads of the test's shape functions by a point of the source, with y × n there.
    #[inline(always)]
    fn add_load(&mut self, load: [Complexes<S>; 3], turning_source: &[Lanes<S>; 3]) {
        for i in 0..3 {
            for z in 0..2 {
                self.load_total[i][z] = self.load_total[i][z] + load[i][z];
                for c in 0..3 {
                    self.load_turning[i][c][z] =
                        load[i][z].times_plus(turning_source[c], self.load_turning[i][c][z]);
                }
            }
        }
    }
}

impl<S: Simd> PairLanes<'_, S> {
    #[inline(always)]
    fn splat(&self, value: f32) -> Lanes<S> {
        Lanes::splat(self.simd, value)
    }

    #[inline(always)]
    fn field(&self, field: usize) -> Lanes<S> {
        Lanes::of(self.simd, self.sources[field * self.parts + self.part])
    }

    #[inline(always)]
    fn vector(&self, field: usize) -> [Lanes<S>; 3] {
        [self.field(field), self.field(field + 1), self.field(field + 2)]
    }

    #[inline(always)]
    fn splats(&self, v: [f32; 3]) -> [Lanes<S>; 3] {
        [self.splat(v[0]), self.splat(v[1]), self.splat(v[2])]
    }

    /// Product of the areas over 4π · 36, zero where the pair is skipped.
    ///
    /// 1/9 is the weight of a pair of points, 1/4 belongs to [`spread`] on both sides.
    #[inline(always)]
    fn amplitude(&self, skip: u16, own: Option<usize>) -> Lanes<S> {
        let common = self.test.area / (4.0 * PI * 36.0);
        let areas = self.field(AREA);
        if skip == 0 && own.is_none() {
            return areas * self.splat(common);
        }
        let first = self.part * S::F32_LANES;
        let mut factors = [0.0_f32; GROUP];
        for (lane, factor) in factors.iter_mut().enumerate().take(S::F32_LANES) {
            if skip >> (first + lane) & 1 == 0 {
                *factor = if own == Some(first + lane) { 0.5 * common } else { common };
            }
        }
        areas * Lanes::of(self.simd, self.simd.partial_load_f32s(&factors[..S::F32_LANES]))
    }

    /// Adds the pair, in both directions, to the sums of the test vertices and the loads.
    #[inline(always)]
    pub(super) fn add<const WITH_MATRIX: bool, const WITH_LOADS: bool>(
        &self,
        skip: u16,
        own: Option<usize>,
        local: &[usize; 3],
        sums: &mut [S::f32s],
        [forward_loads, backward_loads]: [&mut [S::f32s]; 2],
    ) {
        let amplitude = self.amplitude(skip, own);
        let normals = Normals { test: self.splats(self.test.normal), source: self.vector(NORMAL) };
        let integrals = self.integrate::<WITH_LOADS>(&normals);
        if WITH_MATRIX {
            self.add_couplings(&integrals, amplitude, local, sums);
        }
        if !WITH_LOADS {
            return;
        }
        // Only one side is spread: 1/2 instead of 1/4.
        let amplitude = amplitude + amplitude;
        self.add_forward_loads(&integrals, (amplitude, normals.source), local, forward_loads);
        self.add_backward_loads(&integrals, (amplitude, normals.test), backward_loads);
    }

    /// Sums G, its normal derivatives and the loads over the nine pairs of points, projected onto the shape
    /// functions of the inner side.
    #[inline(always)]
    fn integrate<const WITH_LOADS: bool>(&self, normals: &Normals<S>) -> PairIntegrals<S> {
        let zero = self.splat(0.0);
        let p = &self.test.points;
        let x = [self.splats(p[0]), self.splats(p[1]), self.splats(p[2])];
        // iγ'k² n·n, of −γk² n·n.
        let alignment = self.coupling * self.k * self.k * dot(normals.test, normals.source);
        let origin = self.vector(POINT);
        // (x − y)·n_y is the same for all y of a flat triangle.
        let mut above_source = [zero; 3];
        for a in 0..3 {
            above_source[a] = dot(difference(x[a], origin), normals.source);
        }
        let p = &self.test.turning;
        let turning_test = [self.splats(p[0]), self.splats(p[1]), self.splats(p[2])];

        let mut integrals = PairIntegrals::zero(zero);
        // Loop over the points of the source and of the test triangle.
        for b in 0..3 {
            let y = self.vector(POINT + 3 * b);
            // (x − y)·n_x is the same for all x.
            let above_test = dot(difference(x[0], y), normals.test);
            let mut ahead = [[zero; 2]; 3];
            let mut back = [[zero; 2]; 3];
            let mut load = [[zero; 2]; 3];
            for a in 0..3 {
                // Green's function, its normal derivatives on both sides, and the volume term.
                let (value, slope) = self.green(difference(x[a], y));
                let volume = [-(alignment * value[1]), alignment * value[0]];
                let by_source = [above_source[a] * slope[0], above_source[a] * slope[1]];
                let by_test = [above_test * slope[0], above_test * slope[1]];
                ahead[a] = [volume[0] - by_source[0], volume[1] - by_source[1]];
                back[a] = [volume[0] + by_test[0], volume[1] + by_test[1]];
                for z in 0..2 {
                    integrals.total[z] = integrals.total[z] + value[z];
                }
                if !WITH_LOADS {
                    continue;
                }
                // G − iγ' ∂G/∂n, of the test side and of the source side.
                load[a] = [value[0] - self.coupling * by_test[1], value[1] + self.coupling * by_test[0]];
                let other =
                    [value[0] + self.coupling * by_source[1], value[1] - self.coupling * by_source[0]];
                integrals.add_back_load(b, other, &turning_test[a]);
            }
            // Projection onto the shape functions.
            let (ahead, back) = (self.spread(ahead), self.spread(back));
            for i in 0..3 {
                integrals.forward[i][b] = ahead[i];
                integrals.backward[i][b] = back[i];
            }
            if WITH_LOADS {
                integrals.add_load(self.spread(load), &self.vector(TURNING + 3 * b));
            }
        }
        integrals
    }

    /// G · 4π and −(dG/dr)/r · 4π at a distance vector, e^{−ikr}/r and (1/r + ik) e^{−ikr}/r².
    #[inline(always)]
    fn green(&self, d: [Lanes<S>; 3]) -> (Complexes<S>, Complexes<S>) {
        let rate = self.k * self.splat(1.0 / TAU);
        let square = dot(d, d).max(self.splat(1e-12));
        let inverse = square.inverse_root();
        let (sine, cosine) = (square * inverse * rate).turn();
        let value = [inverse * cosine, -(inverse * sine)];
        let slope = [
            inverse * ((-(self.k * value[1])) + inverse * value[0]),
            inverse * (self.k * value[0] + inverse * value[1]),
        ];
        (value, slope)
    }

    /// Adds the entries of both directions to the sums of the test vertices.
    #[inline(always)]
    fn add_couplings(
        &self,
        integrals: &PairIntegrals<S>,
        amplitude: Lanes<S>,
        local: &[usize; 3],
        sums: &mut [S::f32s],
    ) {
        // γ ΣG, and the 1/4 that the shape functions of constants do not have.
        let curl = self.coupling * self.splat(4.0);
        let total = [integrals.total[1] * curl, -(integrals.total[0] * curl)];
        let curls_source = [self.vector(CURL), self.vector(CURL + 3), self.vector(CURL + 6)];
        for i in 0..3 {
            let row = &mut sums[local[i] * SUMS * self.parts..][..SUMS * self.parts];
            let curl_test = self.splats(self.test.curls[i]);
            let (ahead, back) = (self.spread(integrals.forward[i]), self.spread(integrals.backward[i]));
            for j in 0..3 {
                let curls = dot(curl_test, curls_source[j]);
                for z in 0..2 {
                    let both = curls * total[z];
                    let at = (2 * j + z) * self.parts + self.part;
                    self.accumulate(&mut row[at], (ahead[j][z] + both) * amplitude);
                    let at = at + SUMS / 2 * self.parts;
                    self.accumulate(&mut row[at], (back[j][z] + both) * amplitude);
                }
            }
        }
    }

    /// Adds the loads of the test vertices: translations by the source's normal, then rotations.
    #[inline(always)]
    fn add_forward_loads(
        &self,
        integrals: &PairIntegrals<S>,
        (amplitude, n_source): (Lanes<S>, [Lanes<S>; 3]),
        local: &[usize; 3],
        loads: &mut [S::f32s],
    ) {
        for i in 0..3 {
            for z in 0..2 {
                let through = integrals.load_total[i][z] * amplitude;
                for c in 0..3 {
                    let at = (local[i] * LOADS + 2 * c + z) * self.parts + self.part;
                    self.accumulate(&mut loads[at], through * n_source[c]);
                    let at = at + RIGID_DOFS * self.parts;
                    self.accumulate(&mut loads[at], integrals.load_turning[i][c][z] * amplitude);
                }
            }
        }
    }

    /// Adds the loads of the source vertices: translations by the test's normal, then rotations.
    #[inline(always)]
    fn add_backward_loads(
        &self,
        integrals: &PairIntegrals<S>,
        (amplitude, n_test): (Lanes<S>, [Lanes<S>; 3]),
        loads: &mut [S::f32s],
    ) {
        let back_total = self.spread(integrals.back_total);
        let turning = &integrals.back_turning;
        let back_turning = [self.spread(turning[0]), self.spread(turning[1]), self.spread(turning[2])];
        for j in 0..3 {
            for z in 0..2 {
                let through = back_total[j][z] * amplitude;
                for c in 0..3 {
                    let at = (j * LOADS + 2 * c + z) * self.parts + self.part;
                    self.accumulate(&mut loads[at], through * n_test[c]);
                    let at = at + RIGID_DOFS * self.parts;
                    self.accumulate(&mut loads[at], back_turning[c][j][z] * amplitude);
                }
            }
        }
    }

    #[inline(always)]
    fn accumulate(&self, sum: &mut S::f32s, value: Lanes<S>) {
        *sum = self.simd.add_f32s(*sum, value.register());
    }

    /// Twice the integrals against the three shape functions of values at the three points: each function is
    /// 2/3 at its own point and 1/6 at the others.
    #[inline(always)]
    fn spread(&self, values: [Complexes<S>; 3]) -> [Complexes<S>; 3] {
        let third = self.splat(1.0 / 3.0);
        let mut out = values;
        for z in 0..2 {
            let share = (values[0][z] + values[1][z] + values[2][z]) * third;
            for i in 0..3 {
                out[i][z] = values[i][z] + share;
            }
        }
        out
    }
}

#[inline(always)]
fn dot<S: Simd>(a: [Lanes<S>; 3], b: [Lanes<S>; 3]) -> Lanes<S> {
    a[0].times_plus(b[0], a[1].times_plus(b[1], a[2] * b[2]))
}

#[inline(always)]
fn difference<S: Simd>(a: [Lanes<S>; 3], b: [Lanes<S>; 3]) -> [Lanes<S>; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
