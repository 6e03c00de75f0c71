//! Which bodies ring as ellipsoids of the bank, and as which.
//!
//! \[FRAC\] §5.4: a piece of a broken body whose lowest frequency f₀ is above a threshold has a proxy; only
//! f₀ has to be computed for it. What is below has modes of its own, and so has what no bank can stand for.
//! Modes of one's own take seconds to minutes, so that only the lowest few have them. A large piece would
//! need modes above the band of its ellipsoid, and does without.

use std::ops::ControlFlow;
use std::sync::Arc;

use clangor_bake::fem::ElasticConstants;
use clangor_bake::modal::ModalBakeOptions;
use clangor_bake::soundbank::modal::solid_polynomials::{SolidError, lowest_by_polynomials};
use clangor_bake::soundbank::modal::{ModalSoundbankBakeError, first_frequency_of_surface};
use clangor_core::body::{Body, BodyId, Surface};
use clangor_core::material::Material;
use clangor_core::sound_model::soundbank::modal_soundbank::{ModalProxy, ModalSoundbank, ProxyBody};
use rayon::prelude::*;

use crate::formats::modal_soundbank::{bank_material, obtain_modal_soundbank};
use crate::formats::model_cache::ModelCache;

/// Pieces that have modes of their own without being asked for.
const MOST_OWN: usize = 16;
/// Degrees of the polynomials that the lowest frequency of a piece is found by: the next where the last are
/// not independent to rounding, as on a shell that is thin against its curvature.
const RIGID_DOFS: [usize; 4] = [8, 6, 4, 2];

/// A body that may ring as an ellipsoid.
#[derive(Clone, Debug)]
pub(super) struct Candidate {
    pub(super) id: BodyId,
    pub(super) body: Body,
    /// Whatever its lowest frequency is.
    pub(super) always: bool,
}

/// What becomes of it.
#[derive(Clone, Debug)]
pub(super) enum Choice {
    /// It rings as this ellipsoid.
    Proxy(Arc<ModalProxy>),
    /// It has modes of its own.
    Own,
    /// All modes lie above the band; the lowest \[Hz\].
    Above(f64),
    /// Why it does not ring.
    Failed(String),
}

/// What becomes of each, in their order, and what the person should know. `progress` is told which part of a
/// bank that has to be baked is done.
///
/// # Errors
/// [`ModalSoundbankBakeError::Interrupted`].
pub(super) fn choose(
    candidates: &[Candidate],
    options: &ModalBakeOptions,
    threshold: f64,
    cache: Option<&ModelCache>,
    progress: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<(Vec<Choice>, Vec<String>), ModalSoundbankBakeError> {
    let frequencies: Vec<Result<f64, String>> =
        candidates.par_iter().map(|candidate| lowest(&candidate.body)).collect();
    let mut lowest_first: Vec<f64> =
        frequencies.iter().zip(candidates).filter(|(_, c)| !c.always).flat_map(|(f, _)| f.clone()).collect();
    lowest_first.sort_by(f64::total_cmp);
    // Above this there are so many below that a piece has no modes of its own.
    let most_own = lowest_first.get(MOST_OWN).copied().unwrap_or(f64::INFINITY);
    let mut banks: Vec<(Material, Result<ModalSoundbank, String>)> = Vec::new();
    let (mut choices, mut remarks) = (Vec::with_capacity(candidates.len()), Vec::new());
    for (candidate, first) in candidates.iter().zip(frequencies) {
        let Candidate { body, always, .. } = candidate;
        let first = match first {
            Ok(first) => first,
            Err(why) => {
                choices.push(Choice::Failed(why));
                continue;
            }
        };
        if first >= options.max_frequency {
            choices.push(Choice::Above(first));
            continue;
        }
        if !always && first <= threshold && first < most_own {
            choices.push(Choice::Own);
            continue;
        }
        if !banks.iter().any(|(material, _)| same_elasticity(material, &body.material)) {
            let bank = match obtain_modal_soundbank(&body.material, options.medium, cache, progress) {
                Ok(obtained) => {
                    remarks.extend(obtained.remarks);
                    Ok(obtained.bank)
                }
                Err(ModalSoundbankBakeError::Interrupted) => {
                    return Err(ModalSoundbankBakeError::Interrupted);
                }
                Err(error) => {
                    let material = &body.material.name;
                    remarks
                        .push(format!("no modal bank of {material}: {error}; its bodies ring by themselves"));
                    Err(error.to_string())
                }
            };
            banks.push((body.material.clone(), bank));
        }
        let bank = banks.iter().find(|(material, _)| same_elasticity(material, &body.material));
        let Some((_, Ok(bank))) = bank else {
            choices.push(if first < most_own {
                Choice::Own
            } else {
                Choice::Failed("there is no modal bank".into())
            });
            continue;
        };
        // What rings is the homogeneous solid.
        let (inertia, mass) = match body.form_of_uneven() {
            Some(form) => (form.inertia, form.volume * body.material.density),
            None => (body.inertia, body.mass),
        };
        let wanted = ProxyBody {
            inertia,
            mass,
            first_frequency: first,
            material: bank_material(&body.material, options.medium),
            max_frequency: options.max_frequency,
        };
        choices.push(match bank.proxy_for(&wanted) {
            Ok(proxy) => Choice::Proxy(Arc::new(proxy)),
            Err(error) => Choice::Failed(error.to_string()),
        });
    }
    Ok((choices, remarks))
}

/// The lowest frequency \[Hz\] of a body: of a piece by polynomials, of a whole body, which may be
/// thin-walled, by elements.
fn lowest(body: &Body) -> Result<f64, String> {
    let constants = ElasticConstants::of(&body.material).map_err(|error| error.to_string())?;
    match &*body.surface {
        Surface::Mesh(surface) if body.life.parent.is_some() => {
            let mut found = Err(SolidError::Degree(0));
            for degree in RIGID_DOFS {
                found = lowest_by_polynomials(&surface.mesh, &constants, degree);
                if !matches!(found, Err(SolidError::Singular { .. })) {
                    break;
                }
            }
            found.map_err(|error| error.to_string())
        }
        Surface::Mesh(surface) => {
            first_frequency_of_surface(&surface.mesh, &constants).map_err(|error| error.to_string())
        }
        Surface::Sphere { radius } => {
            Ok(BALL_ROOT * (constants.shear_modulus / constants.density).sqrt() / radius)
        }
        Surface::HalfSpace | Surface::Plate { .. } => Err("what is endless has no modes".into()),
    }
}

/// f a/c_s of the lowest mode of a ball, twisting of order 2: 2.501/2π for any Poisson ratio of the usual.
const BALL_ROOT: f64 = 0.398_06;

fn same_elasticity(a: &Material, b: &Material) -> bool {
    let numbers = |m: &Material| [m.youngs_modulus, m.density, m.poisson_ratio];
    numbers(a) == numbers(b)
}
