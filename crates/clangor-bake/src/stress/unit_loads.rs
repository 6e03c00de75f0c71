//! The stress of unit forces at places loaded before: a load there is a linear combination.
//!
//! ```text
//! σ(f) = Σ_j Σ_a f_ja S_ja,    λ₁(σ(f)) ≤ Σ_j Σ_a |f_ja| max over the body of λ₁(± S_ja)
//! ```
//!
//! with S_ja the recovered stress at all corners under a unit force on the patch of vertex j along axis a of
//! a frame whose first axis is the inward normal; ± is the sign of f_ja. The bound on the right holds because
//! the largest principal value of a symmetric tensor is convex and homogeneous of degree one, hence
//! subadditive: λ₁(A + B) ≤ λ₁(A) + λ₁(B). It costs a few products and shows for most loads that nothing
//! breaks.
//!
//! ```text
//! E_S(f) = ½ Σ_i f_i · Σ_j Σ_a f_ja ⟨u_ja⟩_i
//! ```
//!
//! with ⟨u_ja⟩_i the displacement under that unit force, averaged over the patch of vertex i as its force is
//! distributed. u_ja has no rigid motion, so the reaction does no work on it.
//!
//! Stresses are stored in single precision, displacements in double; the least recently used are evicted
//! first. Bounds take six numbers and are kept.

use glam::{DMat3, DVec3};

use super::SymmetricTensor;

const NONE: u32 = u32::MAX;
/// Corners summed together, so that the sums stay in the first-level cache.
const BLOCK: usize = 256;
/// Margin of the bound for rounding in single precision.
const ROUNDING: f64 = 1e-5;

/// The columns of one vertex.
struct Slot {
    vertex: usize,
    last_used: u64,
    /// Axes of the unit forces.
    frame: DMat3,
    /// Stress per force [Pa/N]: for each axis and each of six components, all corners.
    columns: Vec<f32>,
    /// Mean displacement of all patches per force along each axis [m/N].
    patches: [Vec<DVec3>; 3],
}

/// What a unit force on a patch causes.
pub(super) struct UnitResponse {
    /// Stress at all corners [Pa/N].
    pub(super) stress: Vec<SymmetricTensor>,
    /// Mean displacement of all patches [m/N].
    pub(super) patches: Vec<DVec3>,
}

pub(super) struct UnitLoads {
    corners: usize,
    capacity: usize,
    slots: Vec<Slot>,
    slot_of: Vec<u32>,
    /// Frame, and largest λ₁ of each column and of its opposite [Pa/N].
    bounds: Vec<Option<(DMat3, [[f64; 2]; 3])>>,
    clock: u64,
}

impl UnitLoads {
    /// For `vertices` on the surface and `corners` in all.
    pub(super) fn new(vertices: usize, corners: usize, bytes: usize) -> Self {
        let each = 18 * size_of::<f32>() * corners.max(1) + 3 * size_of::<DVec3>() * vertices;
        let capacity = bytes / each;
        UnitLoads {
            corners,
            capacity,
            slots: Vec::new(),
            slot_of: vec![NONE; vertices],
            bounds: vec![None; vertices],
            clock: 0,
        }
    }

    /// Number of vertices that fit.
    pub(super) fn capacity(&self) -> usize {
        self.capacity
    }

    pub(super) fn has(&self, vertex: usize) -> bool {
        self.slot_of[vertex] != NONE
    }

    /// An upper bound of the largest principal stress \[Pa\], if all vertices are stored.
    pub(super) fn bound(&self, forces: &[(usize, DVec3)]) -> Option<f64> {
        let mut sum = 0.0;
        for (vertex, force) in forces {
            let (frame, most) = self.bounds[*vertex].as_ref()?;
            let along = frame.transpose() * *force;
            sum += (0..3).map(|a| along[a].abs() * most[a][usize::from(along[a] < 0.0)]).sum::<f64>();
        }
        Some(sum + ROUNDING * sum.abs())
    }

    /// Marks vertices as recently used, so that they are not evicted.
    pub(super) fn touch(&mut self, forces: &[(usize, DVec3)]) {
        self.clock += 1;
        for (vertex, _) in forces {
            if let Some(slot) = self.slots.get_mut(self.slot_of[*vertex] as usize) {
                slot.last_used = self.clock;
            }
        }
    }

    /// Stores what unit forces along the axes of a frame cause.
    pub(super) fn store(&mut self, vertex: usize, frame: DMat3, responses: [UnitResponse; 3]) {
        let mut columns = vec![0.0_f32; 18 * self.corners];
        for (axis, response) in responses.iter().enumerate() {
            for (n, tensor) in response.stress.iter().enumerate() {
                for (k, value) in tensor.to_array().into_iter().enumerate() {
                    columns[(6 * axis + k) * self.corners + n] = value as f32;
                }
            }
        }
        let most = |response: &UnitResponse| {
            [1.0, -1.0].map(|sign| {
                response.stress.iter().map(|s| (*s * sign).largest()).fold(f64::NEG_INFINITY, f64::max)
            })
        };
        self.bounds[vertex] = Some((frame, responses.each_ref().map(most)));
        let patches = responses.map(|response| response.patches);
        let slot = Slot { vertex, last_used: self.clock, frame, columns, patches };
        let place = if self.slots.len() < self.capacity {
            self.slots.push(slot);
            self.slots.len() - 1
        } else {
            let oldest = (0..self.slots.len()).min_by_key(|s| self.slots[*s].last_used).unwrap_or(0);
            self.slot_of[self.slots[oldest].vertex] = NONE;
            self.slots[oldest] = slot;
            oldest
        };
        self.slot_of[vertex] = place as u32;
    }

    /// Strain energy \[J\]; all vertices must be stored.
    pub(super) fn strain_energy(&self, forces: &[(usize, DVec3)]) -> f64 {
        let work = |(vertex, force): &(usize, DVec3)| {
            let slot = &self.slots[self.slot_of[*vertex] as usize];
            let along = slot.frame.transpose() * *force;
            let by_axis = |a: usize| {
                let moved = forces.iter().map(|(other, push)| push.dot(slot.patches[a][*other]));
                along[a] * moved.sum::<f64>()
            };
            (0..3).map(by_axis).sum::<f64>()
        };
        0.5 * forces.iter().map(work).sum::<f64>()
    }

    /// The corner of largest principal stress, and the stress there \[Pa\]; all vertices must be stored.
    pub(super) fn maximum(&self, forces: &[(usize, DVec3)]) -> (usize, SymmetricTensor) {
        // Relative to the largest force, so that rounding is the same however strong all are.
        let strongest = forces.iter().map(|(_, force)| force.length()).fold(0.0, f64::max);
        let scale = if strongest > 0.0 { strongest } else { 1.0 };
        // Force components in the frames of the vertices, with their columns.
        let terms: Vec<(&[f32], f32)> = forces
            .iter()
            .flat_map(|(vertex, force)| {
                let slot = &self.slots[self.slot_of[*vertex] as usize];
                let along = slot.frame.transpose() * *force;
                (0..3).map(move |a| (&slot.columns[6 * a * self.corners..], (along[a] / scale) as f32))
            })
            .filter(|(_, factor)| *factor != 0.0)
            .collect();
        let (mut most, mut place, mut there) = (f64::NEG_INFINITY, 0, SymmetricTensor::ZERO);
        for start in (0..self.corners).step_by(BLOCK) {
            let count = BLOCK.min(self.corners - start);
            // Linear combination of the columns, block by block.
            let mut sums = [[0.0_f32; BLOCK]; 6];
            for (columns, factor) in &terms {
                for (k, sum) in sums.iter_mut().enumerate() {
                    let from = k * self.corners + start;
                    for (sum, value) in sum.iter_mut().zip(&columns[from..from + count]) {
                        *sum += factor * value;
                    }
                }
            }
            // Largest principal stress; the cheap bound skips most corners.
            for n in 0..count {
                let tensor = SymmetricTensor::from_array(sums.each_ref().map(|sum| f64::from(sum[n])));
                if tensor.most_largest() > most {
                    let largest = tensor.largest();
                    if largest > most {
                        (most, place, there) = (largest, start + n, tensor);
                    }
                }
            }
        }
        (place, there * scale)
    }
}
