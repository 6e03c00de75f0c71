//! A glTF file with the sound of its bodies (`KHR_audio_rigid_bodies`) as an input: `FILE.glb`, or
//! `FILE.glb#BODY`.

use std::path::{Path, PathBuf};

use clangor_core::body::{Body, BodyId};
use clangor_core::material::Material;
use clangor_core::scene::instantiate::LoadedGeometry;
use clangor_core::sound_model::modal::model::ModalModel;
use clangor_pipeline::interchange::audio_rigid_bodies::{EXTENSION, Played, choose_body, read_audio_bodies};
use clangor_pipeline::stages::load::mesh_geometry;

use super::sound_sources::{SAME_VOLUME, is_copy};
use crate::console::Console;
use crate::failure::Failure;

/// A body of such a file.
pub(super) struct AudioInput {
    pub(super) geometry: LoadedGeometry,
    pub(super) material: Material,
    /// Its modes about the centre of mass, if the file has them.
    pub(super) modal: Option<ModalModel>,
}

/// The body that a word names, if the word is such a file; `otherwise` has what the file does not tell of the
/// material.
pub(super) fn audio_input(
    word: &str,
    scale: f64,
    otherwise: Option<&Material>,
    console: &Console,
) -> Result<Option<AudioInput>, Failure> {
    let (file, name) = file_and_body(word);
    let bodies = read_audio_bodies(Path::new(file)).map_err(Failure::new)?;
    let Some(body) = choose_body(bodies, name, file).map_err(Failure::new)? else { return Ok(None) };
    let body = body.scaled(scale);
    let cannot = |e: &dyn std::fmt::Display| Failure::new(format_args!("\"{word}\" cannot be used: {e}"));
    let geometry = mesh_geometry(body.mesh.clone(), 1.0).map_err(|e| cannot(&e))?;
    let Played { material, modal, remarks } =
        body.played(&geometry.mass, otherwise).map_err(|e| cannot(&e))?;
    for remark in geometry.warnings.iter().chain(&remarks) {
        console.warn(format_args!("\"{word}\": {remark}"));
    }
    Ok(Some(AudioInput { geometry, material, modal }))
}

/// Whether a path is that of a glTF file, or of a body in one.
pub(super) fn is_gltf(path: &Path) -> bool {
    ends_in_gltf(file_and_body(&path.to_string_lossy()).0)
}

/// The modes that files give to bodies, and to copies of bodies, by name; the bodies get their decays.
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
        let input = audio_input(&word, 1.0, Some(&first.material), console)?;
        let Some(AudioInput { geometry, material, modal: Some(modes) }) = input else {
            return Err(Failure::new(format_args!("{word} has no modes by {EXTENSION}")));
        };
        let volume = first.mass / first.material.density;
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

/// A file, and the body in it that is meant; a file whose name has a # is one.
fn file_and_body(word: &str) -> (&str, Option<&str>) {
    match word.rsplit_once('#') {
        Some((file, body)) if ends_in_gltf(file) && !Path::new(word).exists() => (file, Some(body)),
        _ => (word, None),
    }
}

fn ends_in_gltf(file: &str) -> bool {
    let ending = Path::new(file).extension().map(|e| e.to_ascii_lowercase());
    ending.is_some_and(|e| e == "glb" || e == "gltf")
}
