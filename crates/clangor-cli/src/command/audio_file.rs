//! Modes out of glTF files with the sound of their bodies (`KHR_audio_rigid_bodies`) for bodies of a scene.

use std::path::PathBuf;

use clangor_core::body::{Body, BodyId};
use clangor_core::sound_model::modal::model::ModalModel;
use clangor_pipeline::interchange::audio_rigid_bodies::EXTENSION;
use clangor_pipeline::session::named_body::GltfBody;

use super::sound_sources::{SAME_VOLUME, is_copy};
use crate::console::Console;
use crate::failure::Failure;

/// Reads the modes that files give to bodies, and to copies of bodies, by name; sets the damping of the
/// bodies to that of the files.
pub(super) fn modes_of_files(
    bodies: &mut [Body],
    files: &[(String, PathBuf)],
    console: &Console,
) -> Result<Vec<(Vec<BodyId>, ModalModel)>, Failure> {
    let mut given = Vec::new();
    for (name, path) in files {
        let copies: Vec<usize> = (0..bodies.len()).filter(|at| is_copy(&bodies[*at], name)).collect();
        let Some(first) = copies.first().map(|at| &bodies[*at]) else {
            return Err(Failure::new(format_args!("--model {name}: there is no body of this name")));
        };
        let word = path.to_string_lossy();
        let file = GltfBody::read(path, 1.0, Some(&first.material))?;
        file.iter().flat_map(|file| &file.remarks).for_each(|remark| console.warn(remark));
        let Some(GltfBody { geometry, material, modal: Some(modes), .. }) = file else {
            return Err(Failure::new(format_args!("{word} has no modes by {EXTENSION}")));
        };
        let volume = first.homogeneous().volume;
        let of_file = geometry.mass.volume;
        if (volume / of_file - 1.0).abs() > SAME_VOLUME {
            console.warn(format_args!(
                "\"{name}\" has {volume:.3e} m³, and {word} is a body of {of_file:.3e} m³"
            ));
        }
        if (first.material.density / material.density - 1.0).abs() > SAME_VOLUME {
            console.warn(format_args!(
                "\"{name}\" has {:.0} kg/m³, and the modes of {word} are those of {:.0} kg/m³: they ring so",
                first.material.density, material.density
            ));
        }
        for at in &copies {
            bodies[*at].material.damping = material.damping.clone();
        }
        given.push((copies.into_iter().map(|at| BodyId(at as u32)).collect(), modes));
    }
    Ok(given)
}
