//! The name of an entry: a hash of everything that a model depends on.

use clangor_bake::acceleration::{BakeOptions, Method};
use clangor_bake::effort::Effort;
use clangor_bake::geometry_class::bake_geometry::BakeGeometry;
use clangor_bake::modal::ModalBakeOptions;
use clangor_bake::modal::held_body::Held;
use clangor_bake::soundbank::modal::ModalSoundbankOptions;
use clangor_core::body::support::{SupportKind, SupportRegion};
use clangor_core::geometry::meridian::Piece;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::glam::DVec3;
use clangor_core::material::Material;
use clangor_core::sound_model::files::{modal_file, modal_soundbank_file, model_file};
use clangor_core::sound_model::modal::model::ModalModel;
use twox_hash::xxhash3_128::Hasher;

/// To be raised when a change to the solvers changes what they compute by more than their accuracy.
const SOLVERS: u32 = 3;
/// The same for fields finer than this error.
const FINE_SOLVERS: u32 = 4;
const FINE: f64 = 0.01;
/// The same for modes and their sound.
const MODAL_SOLVERS: u32 = 12;
/// The same for drafts of them.
const MODAL_DRAFTS: u32 = 13;
/// The same for the bank of ringing ellipsoids.
const BANK_SOLVERS: u32 = 3;
/// The same for the convex parts of meshes, by a change of any bit.
const DECOMPOSITION: u32 = 2;

/// The hash of everything that a baked model depends on, 32 hexadecimal digits. Where it was computed is none
/// of it: what comes from either device is equal to well below any accuracy.
pub fn model_key(geometry: &BakeGeometry, options: &BakeOptions) -> String {
    let mut inputs = Inputs(Hasher::new());
    inputs.text("acceleration");
    inputs.whole(model_file::VERSION.into());
    inputs.whole(if options.accuracy < FINE { FINE_SOLVERS } else { SOLVERS }.into());
    inputs.geometry(geometry);
    inputs.number(options.max_wavenumber);
    inputs.number(options.accuracy);
    inputs.text(match options.method {
        Method::Auto => "auto",
        Method::Bem => "bem",
        Method::Fdtd => "fdtd",
    });
    inputs.whole(options.near_field.into());
    inputs.effort(options.effort);
    format!("{:032x}", inputs.0.finish_128())
}

/// The same of a modal model: supports, elasticity, density and medium besides, and no damping of the
/// material.
pub fn modal_key(
    geometry: &BakeGeometry,
    held: Held<'_>,
    material: &Material,
    options: &ModalBakeOptions,
) -> String {
    let mut inputs = Inputs(Hasher::new());
    inputs.text("modal");
    inputs.whole(modal_file::VERSION.into());
    inputs.modal_solvers(options.effort);
    inputs.geometry(geometry);
    let Material { youngs_modulus, poisson_ratio, density, .. } = *material;
    [youngs_modulus, poisson_ratio, density].into_iter().for_each(|n| inputs.number(n));
    let ModalBakeOptions { medium, max_frequency, mesh_error, most_nodes, accuracy, effort, patience: _ } =
        *options;
    let numbers = [medium.density, medium.sound_speed, max_frequency, mesh_error, accuracy];
    numbers.into_iter().for_each(|n| inputs.number(n));
    inputs.whole(most_nodes as u64);
    inputs.effort(effort);
    inputs.held(held);
    format!("{:032x}", inputs.0.finish_128())
}

/// The same of the sound of modes that somebody else found.
pub fn given_modes_key(geometry: &BakeGeometry, model: &ModalModel, options: &ModalBakeOptions) -> String {
    let mut inputs = Inputs(Hasher::new());
    inputs.text("given modes");
    inputs.whole(modal_file::VERSION.into());
    inputs.modal_solvers(options.effort);
    inputs.geometry(geometry);
    let ModalBakeOptions { medium, accuracy, max_frequency, effort, .. } = *options;
    let numbers = [medium.density, medium.sound_speed, max_frequency, accuracy];
    numbers.into_iter().chain([model.density, model.max_frequency]).for_each(|n| inputs.number(n));
    inputs.whole(model.surface.nodes.len() as u64);
    model.surface.nodes.iter().flat_map(|x| x.to_array()).for_each(|x| inputs.number(x));
    inputs.whole(model.surface.triangles.len() as u64);
    model.surface.triangles.iter().flatten().for_each(|i| inputs.whole((*i).into()));
    inputs.whole(model.modes.len() as u64);
    for mode in &model.modes {
        inputs.number(mode.frequency);
        mode.shape.iter().flat_map(|u| u.to_array()).for_each(|u| inputs.number(u));
    }
    inputs.effort(effort);
    format!("{:032x}", inputs.0.finish_128())
}

/// The hash of everything that a bank of ringing ellipsoids depends on.
pub fn modal_soundbank_key(options: &ModalSoundbankOptions) -> String {
    let mut inputs = Inputs(Hasher::new());
    inputs.text("modal bank");
    inputs.whole(modal_soundbank_file::VERSION.into());
    inputs.whole(BANK_SOLVERS.into());
    let ModalSoundbankOptions { material, max_frequency, least_first_frequency, largest_size, .. } = *options;
    let ModalSoundbankOptions { thinnest, spacing, degree, accuracy, .. } = *options;
    let numbers = [material.youngs_modulus, material.density, material.poisson_ratio];
    numbers.into_iter().for_each(|n| inputs.number(n));
    let numbers = [material.medium.density, material.medium.sound_speed, max_frequency];
    numbers.into_iter().for_each(|n| inputs.number(n));
    let numbers = [least_first_frequency, largest_size, thinnest, spacing, accuracy];
    numbers.into_iter().for_each(|n| inputs.number(n));
    inputs.whole(degree as u64);
    format!("{:032x}", inputs.0.finish_128())
}

/// The hash of everything that the convex parts of a mesh depend on: the mesh and the largest error, if one
/// is asked for.
pub fn collision_parts_key(mesh: &TriMesh, error: Option<f64>) -> String {
    let mut inputs = Inputs(Hasher::new());
    inputs.text("collision parts");
    inputs.whole(DECOMPOSITION.into());
    inputs.mesh(mesh);
    match error {
        Some(error) => inputs.number(error),
        None => inputs.text("default"),
    }
    format!("{:032x}", inputs.0.finish_128())
}

/// Hashes numbers bit by bit.
struct Inputs(Hasher);

impl Inputs {
    /// A word, after its length, so that words do not run into each other.
    fn text(&mut self, text: &str) {
        self.whole(text.len() as u64);
        self.0.write(text.as_bytes());
    }

    fn whole(&mut self, number: u64) {
        self.0.write(&number.to_le_bytes());
    }

    fn number(&mut self, number: f64) {
        // −0 is 0.
        self.0.write(&(number + 0.0).to_le_bytes());
    }

    fn modal_solvers(&mut self, effort: Effort) {
        let version = match effort {
            Effort::Exact => MODAL_SOLVERS,
            Effort::Draft => MODAL_DRAFTS,
        };
        self.whole(version.into());
    }

    /// Exact bakes have the keys of before there were drafts.
    fn effort(&mut self, effort: Effort) {
        if effort == Effort::Draft {
            self.text("draft");
        }
    }

    /// Bodies without supports have the keys of before there were any.
    fn held(&mut self, held: Held<'_>) {
        if held.supports.is_empty() {
            return;
        }
        self.text(if held.moves_freely { "supports that move" } else { "supports" });
        self.whole(held.supports.len() as u64);
        for support in held.supports {
            match support.region {
                SupportRegion::Ball { centre, radius } => {
                    self.text("ball");
                    centre.to_array().into_iter().chain([radius]).for_each(|x| self.number(x));
                }
                SupportRegion::Box { low, high } => {
                    self.text("box");
                    low.to_array().into_iter().chain(high.to_array()).for_each(|x| self.number(x));
                }
            }
            match support.kind {
                SupportKind::Clamped => self.text("clamped"),
                SupportKind::Sprung { stiffness, damping } => {
                    self.text("sprung");
                    let numbers = stiffness.to_array().into_iter().chain(damping.to_array());
                    numbers.for_each(|x| self.number(x));
                }
            }
        }
    }

    fn geometry(&mut self, geometry: &BakeGeometry) {
        match geometry {
            BakeGeometry::Ellipsoid { semi_axes } => {
                self.text("ellipsoid");
                semi_axes.to_array().into_iter().for_each(|a| self.number(a));
            }
            BakeGeometry::RoundedBox { edges, round } => {
                self.text("rounded box");
                edges.to_array().into_iter().for_each(|e| self.number(e));
                self.number(*round);
            }
            BakeGeometry::Axisymmetric { meridian, axis } => {
                self.text("revolution");
                if *axis != DVec3::Y {
                    self.text("about");
                    axis.to_array().into_iter().for_each(|a| self.number(a));
                }
                self.whole(meridian.pieces().len() as u64);
                meridian.pieces().iter().for_each(|piece| self.piece(piece));
            }
            BakeGeometry::Mesh(mesh) => {
                self.mesh(mesh);
                if geometry.encloses_air() {
                    self.text("outside");
                }
            }
        }
    }

    fn mesh(&mut self, mesh: &TriMesh) {
        self.text("mesh");
        self.whole(mesh.vertices.len() as u64);
        mesh.vertices.iter().flat_map(|v| v.to_array()).for_each(|x| self.number(x));
        self.whole(mesh.triangles.len() as u64);
        mesh.triangles.iter().flatten().for_each(|i| self.whole((*i).into()));
    }

    fn piece(&mut self, piece: &Piece) {
        let numbers = match *piece {
            Piece::Line { from, to } => {
                self.text("line");
                [from.x, from.y, to.x, to.y, 0.0, 0.0]
            }
            Piece::Arc { centre, semi_axes, from, to } => {
                self.text("arc");
                [centre.x, centre.y, semi_axes.x, semi_axes.y, from, to]
            }
        };
        numbers.into_iter().for_each(|n| self.number(n));
    }
}
