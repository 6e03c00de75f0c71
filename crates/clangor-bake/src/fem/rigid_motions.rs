//! The zero-energy motions of a free body in closed form: three translations and three rotations.
//!
//! Their frequency is zero. An eigensolver that computed them would have large relative errors there and
//! mistake them for modes. It therefore receives them, orthonormal in the mass.

use glam::DVec3;

/// Six independent rigid motions at the nodes of a body.
pub(super) fn rigid_motions(nodes: &[DVec3]) -> [Vec<DVec3>; 6] {
    let middle = nodes.iter().sum::<DVec3>() / nodes.len().max(1) as f64;
    std::array::from_fn(|k| {
        let axis = DVec3::from_array(std::array::from_fn(|a| if a == k % 3 { 1.0 } else { 0.0 }));
        nodes.iter().map(|x| if k < 3 { axis } else { axis.cross(*x - middle) }).collect()
    })
}

/// Vectors R that span the same motions, with RᵀM R = 1 (Gram–Schmidt); `multiply_mass` writes M x for x.
pub(super) fn orthonormal_in_mass(
    motions: &[Vec<DVec3>],
    multiply_mass: impl Fn(&[f64], &mut [f64]),
) -> Vec<Vec<f64>> {
    let mut heavy = vec![0.0; 3 * motions.first().map_or(0, Vec::len)];
    let mut done: Vec<Vec<f64>> = Vec::with_capacity(motions.len());
    for motion in motions {
        let mut own: Vec<f64> = motion.iter().flat_map(|u| u.to_array()).collect();
        // Each projection twice: the second pass removes the rounding errors of the first.
        for other in done.iter().chain(&done) {
            multiply_mass(&own, &mut heavy);
            let overlap = dot(other, &heavy);
            own.iter_mut().zip(other).for_each(|(x, y)| *x -= overlap * y);
        }
        multiply_mass(&own, &mut heavy);
        let norm = dot(&own, &heavy).sqrt();
        own.iter_mut().for_each(|x| *x /= norm);
        done.push(own);
    }
    done
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
