//! The six motions of a free body that cost no energy, in closed form.
//!
//! Their frequency is zero. A solver that has to find them itself finds them badly, and takes their errors for modes;
//! so it is given them: three translations and three turns, orthonormal in the mass.

use glam::DVec3;

use super::ElasticSystem;

/// Six vectors R with RᵀM R = 1 and K R = 0.
pub fn rigid_motions(system: &ElasticSystem) -> [Vec<f64>; 6] {
    let nodes = system.nodes();
    let middle = nodes.iter().sum::<DVec3>() / nodes.len().max(1) as f64;
    let motion = |k: usize| -> Vec<f64> {
        let axis = DVec3::from_array(std::array::from_fn(|a| if a == k % 3 { 1.0 } else { 0.0 }));
        let at = |x: &DVec3| if k < 3 { axis } else { axis.cross(*x - middle) };
        nodes.iter().flat_map(|x| at(x).to_array()).collect()
    };
    let mut motions: [Vec<f64>; 6] = std::array::from_fn(motion);
    let mut heavy = vec![0.0; 3 * nodes.len()];
    for k in 0..6 {
        // Twice, so that rounding of the first pass is mended.
        for pass in 0..2 * k + 1 {
            let (before, rest) = motions.split_at_mut(k);
            let own = &mut rest[0];
            system.multiply_mass(own, 1, &mut heavy);
            if pass == 2 * k {
                let norm = dot(own, &heavy).sqrt();
                own.iter_mut().for_each(|x| *x /= norm);
            } else {
                let other = &before[pass % k];
                let overlap = dot(other, &heavy);
                own.iter_mut().zip(other).for_each(|(x, y)| *x -= overlap * y);
            }
        }
    }
    motions
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
