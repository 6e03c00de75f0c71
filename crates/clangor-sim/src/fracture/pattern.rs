//! Fracture pattern: regions around seeds, as many as the strain energy allows.
//!
//! ```text
//! P(seed at node i) ∝ w_i V_i,    w energy density, V_i volume of the node
//! region of a node = argmin_i k_i d(node, p_i),    k_i = (w(p_i) / w̄)^α,    w̄ = E_S / V
//! seeds are added while  G_c A_F ≤ η E_S
//! ```
//!
//! d is the length of the shortest way along edges, found from all seeds at once, so that each region is
//! connected. A large k makes a small region: pieces are small where the energy was high. A_F is the area of
//! the walls that `split` will cut, each counted once; the volumes of pieces are those that it will produce.
//!
//! Source: \[FRAC\] §3.2. Differs: the energy density in k is divided by its mean w̄, so that k has no unit
//! (only ratios affect the regions), and is limited to at least 1e-6 of it, so that an unstrained seed does
//! not take the whole body. A seed is drawn again, a few times, if its piece or a neighbouring piece would be
//! too small, or if its cracks would cost too much, since another may cost less.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use clangor_bake::mesh::tetrahedra::{EDGES, TetMesh};
use clangor_core::glam::DVec3;
use clangor_core::math::random::SplitMix;

use super::error::FractureError;
use super::tetrahedron::six_volumes;
use super::tetrahedron_parts::{distinct, shares, wall};

/// Least energy density in the weight of distances, as a share of the mean.
const LEAST_DENSITY: f64 = 1e-6;
/// Consecutive rejected seeds after which the pattern is complete.
const TRIES: usize = 8;
/// First seeds without a second one after which the body stays whole.
const FIRST_TRIES: usize = 4;

/// Settings of a fracture pattern.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatternSettings {
    /// Energy per area of crack G_c \[J/m²\].
    pub fracture_energy: f64,
    /// Largest share η of the strain energy that goes into cracks.
    pub efficiency: f64,
    /// Exponent α of the energy density in the weight of distances.
    pub exponent: f64,
    /// Least volume of a piece \[m³\].
    pub smallest_piece: f64,
    /// Most pieces of one fracture.
    pub most_pieces: usize,
    /// Seed of the random numbers.
    pub seed: u64,
}

impl PatternSettings {
    /// \[FRAC\]'s η = 0.8 and α = 0.15, for a body of known volume \[m³\]: pieces of at least a hundred
    /// thousandth of it, at most 1000.
    pub fn new(fracture_energy: f64, volume: f64, seed: u64) -> Self {
        PatternSettings {
            fracture_energy,
            efficiency: 0.8,
            exponent: 0.15,
            smallest_piece: 1e-5 * volume,
            most_pieces: 1000,
            seed,
        }
    }

    pub(super) fn check(&self) -> Result<(), FractureError> {
        let numbers = [
            ("fracture_energy", self.fracture_energy, self.fracture_energy > 0.0),
            ("efficiency", self.efficiency, self.efficiency > 0.0 && self.efficiency <= 1.0),
            ("exponent", self.exponent, self.exponent >= 0.0),
            ("smallest_piece", self.smallest_piece, self.smallest_piece >= 0.0),
        ];
        match numbers.into_iter().find(|(_, value, good)| !(*good && value.is_finite())) {
            Some((setting, value, _)) => Err(FractureError::Setting { setting, value }),
            None => Ok(()),
        }
    }
}

/// Regions of a body.
#[derive(Clone, Debug, PartialEq)]
pub struct Pattern {
    /// The region of each corner of the mesh.
    pub region: Vec<u32>,
    /// The seed corner of each region.
    pub seeds: Vec<u32>,
    /// Volume of each region \[m³\].
    pub volumes: Vec<f64>,
    /// Area A_F of the walls between regions \[m²\].
    pub area: f64,
    /// Strain energy E_S \[J\].
    pub strain_energy: f64,
    /// Energy E_F = G_c A_F of the cracks \[J\].
    pub fracture_energy: f64,
}

/// Draws a pattern; `energy_density` \[J/m³\] is given for each corner of the mesh. `None` if no crack is
/// small enough for the energy; the body then stays whole.
///
/// # Errors
/// [`FractureError::Setting`] or [`FractureError::Counts`].
pub fn draw_pattern(
    mesh: &TetMesh,
    energy_density: &[f64],
    strain_energy: f64,
    settings: &PatternSettings,
) -> Result<Option<Pattern>, FractureError> {
    settings.check()?;
    if energy_density.len() != mesh.corners {
        return Err(FractureError::Counts {
            what: "energy densities",
            got: energy_density.len(),
            wanted: mesh.corners,
        });
    }
    let numbers = energy_density.iter().copied().chain([strain_energy]);
    if let Some(value) = numbers.into_iter().find(|w| !(*w >= 0.0 && w.is_finite())) {
        return Err(FractureError::Setting { setting: "energy density or strain energy", value });
    }
    let body = Body::of(mesh, energy_density);
    if body.energy <= 0.0 || strain_energy <= 0.0 || settings.most_pieces < 2 {
        return Ok(None);
    }
    let mut random = SplitMix::new(settings.seed);
    let affordable = settings.efficiency * strain_energy / settings.fracture_energy;
    for _ in 0..FIRST_TRIES {
        let first = vec![body.draw(&mut random)];
        let Some(mut best) = body.next(&first, &mut random, affordable, settings) else { continue };
        while best.seeds.len() < settings.most_pieces {
            let Some(next) = body.next(&best.seeds, &mut random, affordable, settings) else { break };
            best = next;
        }
        let fracture_energy = settings.fracture_energy * best.area;
        return Ok(Some(Pattern { strain_energy, fracture_energy, ..best }));
    }
    Ok(None)
}

/// A mesh with the data for repeated division.
struct Body<'a> {
    mesh: &'a TetMesh,
    /// Index of the first neighbour of each corner.
    starts: Vec<u32>,
    neighbours: Vec<(u32, f64)>,
    volumes: Vec<f64>,
    /// Cumulative energy up to each corner \[J\], for drawing seeds.
    sums: Vec<f64>,
    energy: f64,
    /// Energy density of each corner over the mean.
    relative: Vec<f64>,
}

impl<'a> Body<'a> {
    fn of(mesh: &'a TetMesh, energy_density: &[f64]) -> Self {
        let mut nodal = vec![0.0; mesh.corners];
        let mut volumes = Vec::with_capacity(mesh.elements.len());
        let mut edges: Vec<[u32; 2]> = Vec::with_capacity(12 * mesh.elements.len());
        for element in &mesh.elements {
            let corners = [0, 1, 2, 3].map(|k| element[k]);
            let volume = six_volumes(corners.map(|n| mesh.nodes[n as usize])) / 6.0;
            corners.iter().for_each(|n| nodal[*n as usize] += 0.25 * volume);
            volumes.push(volume);
            let both = |[i, j]: [usize; 2]| [[corners[i], corners[j]], [corners[j], corners[i]]];
            edges.extend(EDGES.into_iter().flat_map(both));
        }
        // Adjacency lists of the corners.
        edges.sort_unstable();
        edges.dedup();
        let mut starts = vec![0; mesh.corners + 1];
        edges.iter().for_each(|[from, _]| starts[*from as usize + 1] += 1);
        for k in 0..mesh.corners {
            starts[k + 1] += starts[k];
        }
        let length = |[a, b]: &[u32; 2]| (*b, mesh.nodes[*a as usize].distance(mesh.nodes[*b as usize]));
        let mut energy = 0.0;
        let sums = energy_density
            .iter()
            .zip(&nodal)
            .map(|(density, volume)| {
                energy += density * volume;
                energy
            })
            .collect();
        let mean = energy / volumes.iter().sum::<f64>();
        let relative = energy_density.iter().map(|w| (w / mean).max(LEAST_DENSITY)).collect();
        let neighbours = edges.iter().map(length).collect();
        Body { mesh, starts, neighbours, volumes, sums, energy, relative }
    }

    /// Draws a corner with a probability proportional to its energy.
    fn draw(&self, random: &mut SplitMix) -> u32 {
        let level = random.uniform(0.0, self.energy);
        // Corners without energy have the cumulative energy of their predecessor and are never drawn.
        self.sums.partition_point(|sum| *sum <= level).min(self.sums.len() - 1) as u32
    }

    /// The regions with one more seed, if a seed is found whose cracks are affordable and whose pieces are
    /// large enough.
    fn next(
        &self,
        seeds: &[u32],
        random: &mut SplitMix,
        affordable: f64,
        settings: &PatternSettings,
    ) -> Option<Pattern> {
        (0..TRIES).find_map(|_| {
            let drawn = self.draw(random);
            if seeds.contains(&drawn) {
                return None;
            }
            let seeds: Vec<u32> = seeds.iter().copied().chain([drawn]).collect();
            let region = self.grow(&seeds, settings.exponent);
            let (volumes, area) = measure(self.mesh, &self.volumes, &region, seeds.len());
            let large = volumes.iter().all(|v| *v >= settings.smallest_piece);
            (large && area <= affordable).then_some(Pattern {
                region,
                seeds,
                volumes,
                area,
                strain_energy: 0.0,
                fracture_energy: 0.0,
            })
        })
    }

    /// The region of each corner, by Dijkstra's algorithm from all seeds.
    fn grow(&self, seeds: &[u32], exponent: f64) -> Vec<u32> {
        const NONE: u32 = u32::MAX;
        let mut region = vec![NONE; self.mesh.corners];
        let mut nearest = vec![f64::INFINITY; self.mesh.corners];
        // The bit patterns of positive numbers have the order of the numbers.
        let mut front: BinaryHeap<Reverse<(u64, u32, u32)>> = BinaryHeap::new();
        let slowness: Vec<f64> = seeds.iter().map(|s| self.relative[*s as usize].powf(exponent)).collect();
        for (k, seed) in seeds.iter().enumerate() {
            nearest[*seed as usize] = 0.0;
            front.push(Reverse((0, k as u32, *seed)));
        }
        while let Some(Reverse((bits, own, corner))) = front.pop() {
            let corner = corner as usize;
            if region[corner] != NONE {
                continue;
            }
            region[corner] = own;
            let way = f64::from_bits(bits);
            let range = self.starts[corner] as usize..self.starts[corner + 1] as usize;
            for (next, length) in &self.neighbours[range] {
                let there = way + slowness[own as usize] * length;
                if region[*next as usize] == NONE && there < nearest[*next as usize] {
                    nearest[*next as usize] = there;
                    front.push(Reverse((there.to_bits(), own, *next)));
                }
            }
        }
        // Corners that no seed reaches are in a disconnected part, which joins the first region.
        region.iter_mut().filter(|r| **r == NONE).for_each(|r| *r = 0);
        region
    }
}

/// Volumes of regions \[m³\] and area of the walls between them \[m²\].
fn measure(mesh: &TetMesh, volumes: &[f64], region: &[u32], regions: usize) -> (Vec<f64>, f64) {
    let mut sums = vec![0.0; regions];
    let mut area = 0.0;
    for (element, volume) in mesh.elements.iter().zip(volumes) {
        let corners = [0, 1, 2, 3].map(|k| element[k] as usize);
        let own = corners.map(|n| region[n]);
        if own == [own[0]; 4] {
            sums[own[0] as usize] += volume;
            continue;
        }
        let share = shares(own);
        for (k, r) in own.iter().enumerate().filter(|(k, r)| !own[..*k].contains(r)) {
            sums[*r as usize] += share[k] * volume;
        }
        let places = corners.map(|n| mesh.nodes[n]);
        area += walls_area(places, own);
    }
    (sums, area)
}

/// Area of the walls within one tetrahedron \[m²\].
fn walls_area(places: [DVec3; 4], regions: [u32; 4]) -> f64 {
    let mut area = 0.0;
    for (k, a) in distinct(regions).enumerate() {
        for b in distinct(regions).take(k) {
            let polygon = wall(regions, a, b);
            let place = |mask: u8| {
                let own = (0..4).filter(|k| mask >> k & 1 == 1);
                own.map(|k| places[k]).sum::<DVec3>() / f64::from(mask.count_ones())
            };
            let ring: Vec<DVec3> = polygon.points().iter().map(|m| place(*m)).collect();
            let fan = ring[1..].windows(2).map(|w| (w[0] - ring[0]).cross(w[1] - ring[0]).length());
            area += 0.5 * fan.sum::<f64>();
        }
    }
    area
}
