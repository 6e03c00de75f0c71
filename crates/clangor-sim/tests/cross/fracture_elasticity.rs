//! Pieces are meshes that the elastic solver can use: a body under uniform strain needs no force inside.

use clangor_bake::fem::{ElasticConstants, ElasticSystem};
use clangor_bake::mesh::tetrahedra::block::block;
use clangor_core::glam::{DMat3, DVec3};
use clangor_sim::fracture::pattern::PatternSettings;
use clangor_sim::fracture::piece::Piece;
use clangor_sim::fracture::shatter;

#[test]
fn pieces_of_pieces_pass_the_patch_test() {
    let glass = ElasticConstants { lame_lambda: 2.3e10, shear_modulus: 3e10, density: 2500.0 };
    let body = Piece::whole(&block(DVec3::new(0.1, 0.08, 0.06), [5, 4, 3]).unwrap()).unwrap();
    let volume = body.mass_properties().unwrap().volume;
    let break_up = |body: &Piece, seed| {
        let settings = PatternSettings { most_pieces: 3, ..PatternSettings::new(1.0, volume, seed) };
        shatter(body, &vec![1.0; body.mesh.corners], 1e9, &settings).unwrap().unwrap().pieces
    };
    let pieces = break_up(&body, 1).into_iter().flat_map(|p| break_up(&p, 2));
    let strain = DMat3::from_cols_array(&[1.0, 0.3, -0.2, 0.3, -0.5, 0.1, -0.2, 0.1, 0.7]);
    for piece in pieces {
        let system = ElasticSystem::new(&piece.mesh, &glass);
        let displacement: Vec<f64> = piece.mesh.nodes.iter().flat_map(|p| (strain * *p).to_array()).collect();
        let mut force = vec![0.0; displacement.len()];
        system.multiply_stiffness(&displacement, 1, &mut force);
        let mut on_surface = vec![false; piece.mesh.nodes.len()];
        piece.mesh.surface().iter().flatten().for_each(|n| on_surface[*n as usize] = true);
        let sizes: Vec<f64> = force.chunks(3).map(|f| DVec3::from_slice(f).length()).collect();
        let largest = sizes.iter().copied().fold(0.0, f64::max);
        let inside = sizes.iter().zip(&on_surface).filter(|(_, s)| !**s).map(|(f, _)| *f);
        // Seen: 3e-15 of the largest force at the surface.
        assert!(inside.fold(0.0, f64::max) < 1e-11 * largest);
        let total: DVec3 = force.chunks(3).map(DVec3::from_slice).sum();
        assert!(total.length() < 1e-10 * largest);
    }
}
