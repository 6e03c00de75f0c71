//! The motions of a free body that cost no energy, in closed form: three translations and three turns.
//!
//! Their frequency is zero. A solver that has to find them itself finds them badly, and takes their errors
//! for modes; so it is given them, orthonormal in the mass.

use glam::DVec3;

use super::ElasticSystem;

/// Six independent rigid motions at the nodes of a body.
pub(super) fn rigid_motions(nodes: &[DVec3]) -> [Vec<DVec3>; 6] {
    let middle = nodes.iter().sum::<DVec3>() / nodes.len().max(1) as f64;
    std::array::from_fn(|k| {
        let axis = DVec3::from_array(std::array::from_fn(|a| if a == k % 3 { 1.0 } else { 0.0 }));
        nodes.iter().map(|x| if k < 3 { axis } else { axis.cross(*x - middle) }).collect()
    })
}

/// Vectors R that span the same, with RᵀM R = 1.
pub(super) fn normalised(system: &ElasticSystem, motions: &[Vec<DVec3>]) -> Vec<Vec<f64>> {
    let mut heavy = vec![0.0; 3 * system.node_count()];
    let mut done: Vec<Vec<f64>> = Vec::with_capacity(motions.len());
    for motion in motions {
        let mut own: Vec<f64> = motion.iter().flat_map(|u| u.to_array()).collect();
        // Twice, so that rounding of the first pass is mended.
        for other in done.iter().chain(&done) {
            system.multiply_mass(&own, 1, &mut heavy);
            let overlap = dot(other, &heavy);
            own.iter_mut().zip(other).for_each(|(x, y)| *x -= overlap * y);
        }
        system.multiply_mass(&own, 1, &mut heavy);
        let norm = dot(&own, &heavy).sqrt();
        own.iter_mut().for_each(|x| *x /= norm);
        done.push(own);
    }
    done
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
