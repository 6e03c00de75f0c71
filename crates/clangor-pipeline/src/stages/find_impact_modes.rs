//! The modes with which the bodies of a scene meet impacts, found before anything moves.
//!
//! A body has them if supports hold it, or if it is so thin or slender that vibration takes a part of its
//! impacts, fixed or not. Two bounds decide, with the thickness h = 2V/A and the extent L of the body, and a
//! reference contact: its own mass m and its own material on both sides, relative radius 5 mm, V = 1 m/s.
//!
//! ```text
//! λ = Y m/T₀ > 0.01    Y = 1/(8 √(D m″))    T₀ = (m/(k √V))^{2/5}    Zener's parameter of inelasticity
//! f₁ τ < 1.5           f₁ = 0.6 h c_p/L²     τ = 3.2 T₀              lowest bending mode of a plate
//! ```
//!
//! No lighter partner has a larger λ; for a fixed body, too, partners up to its own mass count. At f₁ τ = 1.5
//! the spectrum of Hertz's pulse has fallen to 0.1, and modes get its square. Spheres are compact and have
//! none.
//!
//! Band, mesh error and medium follow from the body alone, so that motion does not depend on how a scene is
//! rendered: air, 1 %, and the lower of 20 kHz and the frequency below which a plate of its area S and
//! thickness has N = 150 modes. Above the band, the tail of the solver takes their place. In cells the error
//! is 15 %, of the worst mode, which the first grid mostly meets: the impulses of a mug and a jug then are
//! within 0.8 % of those with 2 %, which takes eight to thirteen times as long, and the first of a toy car of
//! eight parts is within 0.2 % of that with 1 %, which takes 170 times as long.
//!
//! ```text
//! f_N = 2 N √(D/m″)/S
//! ```
//!
//! On free panes of glass, N = 100 moves the restitution of a ball by less than 0.015, N = 50 by 0.04. Where
//! all of them take more than 40 s of CPU time by estimate, a draft takes their place: about a hundred
//! modes in few elements, whose frequencies are some 3 % too high.
//!
//! Shapes are rounded as in a file, so that a model from the cache and a baked one are the same. Damping is
//! that of the material and the supports. Only the modes are found here, not their sound; a
//! render to 20 kHz goes on from those that reach it.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Instant;

use clangor_bake::acceleration::BakeProgress;
use clangor_bake::cost::PER_SECOND;
use clangor_bake::geometry_class::solver_choice::ModalChoice;
use clangor_bake::modal::ModalBakeOptions;
use clangor_core::body::{Body, BodyId, Surface};
use clangor_core::material::Material;
use clangor_core::medium::Medium;
use clangor_core::scene::simulation_description::{ContactModel, SolverChoice};
use clangor_core::sound_model::ModalRule;
use clangor_core::synthesis::SoundPart;

use super::impact_modes::{ImpactModes, ModalShapes};
use super::load::LoadedScene;
use super::simulate::solver;
use super::sound_models::modal_bake::{obtain_modes, vibrates_alike};
use super::sound_models::modal_plan::MOST_FORMS;
use super::sound_models::request::RequestedPart;
use super::sound_models::{ModalBake, SoundModelError, SoundModelProgress, SoundModelRequest};
use crate::formats::model_cache::ModelCache;

/// Least Zener parameter of a body that gives way.
const LEAST_INELASTICITY: f64 = 0.01;
/// Largest f₁ τ of such a body.
const MOST_PERIODS: f64 = 1.5;
/// Relative radius of the reference contact \[m\].
const RADIUS: f64 = 5e-3;
/// Modes in the band of a body, by those of a plate.
const MODES: f64 = 150.0;
/// Mesh error of modes in cells.
const ERROR_IN_CELLS: f64 = 0.15;

/// Operations that the modes of a body may take, by [`clangor_bake::cost`].
const MOST_OPERATIONS: f64 = 40.0 * PER_SECOND;

/// Finds the modes of the bodies that give way, in the cache or by a bake, for
/// [`LoadedScene::give_modes`]. Those that cannot be had make a remark.
///
/// # Errors
/// [`SoundModelError::Interrupted`], when `progress` breaks.
pub fn find_impact_modes(
    loaded: &LoadedScene,
    cache: Option<&ModelCache>,
    progress: &mut dyn FnMut(&SoundModelProgress<'_>) -> ControlFlow<()>,
) -> Result<ImpactModes, SoundModelError> {
    let mut found = ImpactModes::default();
    let solves =
        loaded.scene.simulation.contact == ContactModel::Compliant && solver(loaded) == SolverChoice::Rigid;
    let forms = if solves { forms(loaded, &mut found.remarks) } else { Vec::new() };
    let (count, mut stiff) = (forms.len() as f64, Vec::new());
    for (at, (request, bodies)) in forms.iter().enumerate() {
        let started = Instant::now();
        let first = &loaded.world.bodies[bodies[0].index()];
        let mut on_progress = |p: &BakeProgress| {
            let done = (at as f64 + p.done) / count;
            progress(&SoundModelProgress { part: SoundPart::Modal, body: &first.name, done, step: p.stage })
        };
        match obtain_modes(request, cache, &mut on_progress) {
            Ok((model, _)) if model.modes.is_empty() => stiff.extend(bodies),
            Ok((model, cached)) => {
                found.obtained.push((bodies[0], cached, started.elapsed()));
                // What is above the known modes is the tail of the solver.
                let shapes = Arc::new(ModalShapes::new(request.key(), model.without_synthetic_modes()));
                for id in bodies {
                    found.insert(*id, &shapes, &loaded.world.bodies[id.index()].material.damping);
                }
            }
            Err(SoundModelError::Interrupted) => return Err(SoundModelError::Interrupted),
            Err(error) => found.remarks.push(format!(
                "the modes of \"{}\" cannot be found: {error}; it collides rigidly",
                first.name
            )),
        }
    }
    if solves {
        let thin = |body: &Body| Plate::of(body).is_some_and(|plate| plate.gives_way());
        let bodies = (0..).map(BodyId).zip(&loaded.world.bodies).filter(|(_, body)| thin(body));
        let unknown = bodies.filter(|(id, _)| !found.contains(*id) && !stiff.contains(id));
        found.rigid = unknown.map(|(id, _)| id).collect();
    }
    Ok(found)
}

/// A form and material, and the bodies that have it.
type Form = (SoundModelRequest<ModalBake>, Vec<BodyId>);

/// The forms of the bodies that give way; none if they are too many.
fn forms(loaded: &LoadedScene, remarks: &mut Vec<String>) -> Vec<Form> {
    let rules = loaded.scene.sound_rules();
    let mut forms: Vec<Form> = Vec::new();
    let mut known: Vec<(usize, &Body, usize)> = Vec::new();
    for (index, body) in loaded.world.bodies.iter().enumerate() {
        let silent = rules.get(index).is_some_and(|rule| rule.modal == ModalRule::Never);
        let Some(plate) = Plate::of(body).filter(|plate| !silent && plate.gives_way()) else { continue };
        let id = BodyId(index as u32);
        let surface = Arc::as_ptr(&body.surface).addr();
        let copy = known.iter().find(|(s, other, _)| *s == surface && vibrates_alike(other, body));
        if let Some((_, _, at)) = copy {
            forms[*at].1.push(id);
            continue;
        }
        let options = ModalBakeOptions::new(Medium::AIR);
        let max_frequency = options.max_frequency.min(plate.frequency_of_mode(MODES));
        let part = ModalBake::of_body(body, ModalBakeOptions { max_frequency, ..options });
        let Ok(mut request) = SoundModelRequest::of_body(body, part) else { continue };
        if matches!(request.geometry().modal_choice(), Ok(ModalChoice::Cells(_))) {
            request = request.with_part(request.part().with_mesh_error(ERROR_IN_CELLS));
        }
        if request.part().operations_of_modes(request.geometry()) > MOST_OPERATIONS {
            request = request.with_part(request.part().draft());
        }
        let at = forms.iter().position(|(other, _)| other.key() == request.key());
        let at = at.unwrap_or(forms.len());
        if at == forms.len() {
            forms.push((request, Vec::new()));
        }
        forms[at].1.push(id);
        known.push((surface, body, at));
        if forms.len() > MOST_FORMS {
            remarks.push(format!(
                "more than {MOST_FORMS} different thin or supported bodies: all bodies of this scene collide \
                 rigidly"
            ));
            return Vec::new();
        }
    }
    forms
}

/// A body as a plate of its volume, surface and extent.
struct Plate<'b> {
    body: &'b Body,
    thickness: f64,
    /// Area of one side \[m²\].
    area: f64,
    extent: f64,
    /// E/(1 − ν²) \[Pa\].
    plane_strain: f64,
    /// Bending stiffness D \[N m\].
    bending: f64,
    /// Mass per area m″ \[kg/m²\].
    mass_per_area: f64,
}

impl<'b> Plate<'b> {
    /// `None` for spheres and planes.
    fn of(body: &'b Body) -> Option<Self> {
        let Surface::Mesh(surface) = &*body.surface else { return None };
        let Material { youngs_modulus, poisson_ratio, density, .. } = body.material;
        let area = 0.5 * surface.mesh.area();
        let thickness = surface.volume / area;
        let plane_strain = youngs_modulus / (1.0 - poisson_ratio * poisson_ratio);
        Some(Plate {
            body,
            thickness,
            area,
            extent: 2.0 * body.surface.bounding_radius(),
            plane_strain,
            bending: plane_strain * thickness.powi(3) / 12.0,
            mass_per_area: density * thickness,
        })
    }

    /// Whether vibration may take a part of its impacts; see the module.
    fn gives_way(&self) -> bool {
        if !self.body.supports.is_empty() {
            return true;
        }
        // Zener's λ of the reference contact.
        let mobility = 1.0 / (8.0 * (self.bending * self.mass_per_area).sqrt());
        let stiffness = 4.0 / 3.0 * 0.5 * self.plane_strain * RADIUS.sqrt();
        let time = (self.body.mass / stiffness).powf(0.4);
        // Lowest bending mode.
        let speed = (self.plane_strain / self.body.material.density).sqrt();
        let first = 0.6 * self.thickness * speed / (self.extent * self.extent);
        mobility * self.body.mass / time > LEAST_INELASTICITY && first * 3.2 * time < MOST_PERIODS
    }

    /// Frequency \[Hz\] below which it has so many bending modes, on average.
    fn frequency_of_mode(&self, count: f64) -> f64 {
        2.0 * count * (self.bending / self.mass_per_area).sqrt() / self.area
    }
}
