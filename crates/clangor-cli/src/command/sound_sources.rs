//! Sound models that the command line gives to bodies, and its names of rules.

use std::path::PathBuf;
use std::sync::Arc;

use clangor_core::body::{Body, BodyId};
use clangor_core::reference::PanSource;
use clangor_core::reference::pan_file::PanFile;
use clangor_core::sound_model::AccelerationRule;
use clangor_core::sound_model::acceleration::model_evaluator::ModelEvaluator;
use clangor_core::sound_model::files::model_file::Solid;
use clangor_core::synthesis::SoundSource;
use clangor_core::synthesis::source_rule::{Decision, Reason, SourceKind, source_of};
use clangor_pipeline::stages::sound_models::{OtherMaterial, SoundFile, SoundModelPlan, read_sound_file};

use crate::arguments::Sound;
use crate::console::Console;
use crate::failure::Failure;

impl From<Sound> for AccelerationRule {
    fn from(sound: Sound) -> Self {
        match sound {
            Sound::Auto => AccelerationRule::Auto,
            Sound::Own => AccelerationRule::Own,
            Sound::Proxy => AccelerationRule::Proxy,
            Sound::NearestProxy => AccelerationRule::NearestProxy,
            Sound::Sphere => AccelerationRule::Sphere,
        }
    }
}

/// Part of a body's volume by which that of the solid that a given model was baked from may differ.
pub(super) const SAME_VOLUME: f64 = 0.02;

/// From a body to its sound by a model.
type Play = Box<dyn Fn(&Body) -> SoundSource>;

/// Gives the plan the models that the command line gives to bodies, and to copies of bodies, by name.
pub(super) fn give_models(
    plan: &mut SoundModelPlan,
    bodies: &[Body],
    given: &[(String, PathBuf)],
    console: &Console,
) -> Result<(), Failure> {
    for (name, path) in given {
        let file = read_sound_file(path).map_err(Failure::new)?;
        let unplayable =
            |why: &dyn std::fmt::Display| Failure::new(format_args!("{}: {why}", path.display()));
        let (play, modal, solid): (Option<Play>, _, Solid) = match file {
            SoundFile::Model(file) => {
                let own = ModelEvaluator::try_new(&file.acceleration).map_err(|e| unplayable(&e))?;
                let decision = Decision { kind: SourceKind::Own, reason: Reason::Asked };
                let play = move |body: &Body| source_of(body, &decision, None, Some(&own)).0;
                (Some(Box::new(play)), file.modal, file.solid)
            }
            SoundFile::Modal(file) => (None, Some(file.modal), file.solid),
            SoundFile::Pan(file) => {
                let PanFile { model, solid, .. } = *file;
                let model = Arc::new(model);
                let play = move |body: &Body| {
                    let source = PanSource::new(Arc::clone(&model), Arc::clone(&body.surface));
                    SoundSource::Reference(Arc::new(source))
                };
                (Some(Box::new(play)), None, solid)
            }
            SoundFile::Bank(_) | SoundFile::ModalSoundbank(_) => {
                return Err(unplayable(&"is a soundbank, not the model of one body"));
            }
        };
        let volume_of_solid = solid.mass.volume;
        let modes = modal.map(|modal| (Arc::new(modal.model.clone()), modal));
        let mut found = false;
        for (index, body) in bodies.iter().enumerate().filter(|(_, body)| is_copy(body, name)) {
            found = true;
            let id = BodyId(index as u32);
            let volume = body.homogeneous().volume;
            if (volume / volume_of_solid - 1.0).abs() > SAME_VOLUME {
                console.warn(format_args!(
                    "\"{}\" has {volume:.3e} m³, and {} is the model of {volume_of_solid:.3e} m³",
                    body.name,
                    path.display(),
                ));
            }
            if let Some(play) = &play {
                plan.give_acceleration(id, play(body));
            }
            if let Some((model, modal)) = &modes {
                OtherMaterial::find(&body.material, modal).iter().for_each(|remark| console.warn(remark));
                plan.give_modal(id, Arc::clone(model));
            }
        }
        if !found {
            return Err(Failure::new(format_args!("--model {name}: there is no body of this name")));
        }
    }
    Ok(())
}

/// Whether a body has this name, or is one of the copies of the body that has it.
pub(super) fn is_copy(body: &Body, name: &str) -> bool {
    let number = body.name.strip_prefix(name).and_then(|rest| rest.strip_prefix('-'));
    body.name == *name || number.is_some_and(|n| !n.is_empty() && n.bytes().all(|c| c.is_ascii_digit()))
}
