//! Members of an impact with the modes that the modal analysis of their shapes finds.

use std::f64::consts::TAU;
use std::ops::ControlFlow;

use clangor_bake::fem::ElasticConstants;
use clangor_bake::geometry_class::bake_geometry::BakeGeometry;
use clangor_bake::modal_analysis::{ModalAnalysisOptions, modal_analysis};
use clangor_core::contact::compliant::{ContactLaw, Member, MemberContact};
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::glam::{DMat3, DVec3};
use clangor_core::material::Material;
use clangor_core::material::presets::{Preset, STEEL};
use clangor_core::shape::Shape;
use num_complex::Complex64;

/// A body about its centre of mass, in the axes of its shape.
pub(crate) struct BakedBody {
    pub(crate) member: Member,
    pub(crate) material: Material,
    /// Frequencies up to which all modes are known \[Hz\].
    pub(crate) highest: f64,
    /// Corners of the triangles of the surface \[m\], with their outward unit normals.
    pub(crate) places: Vec<Place>,
    /// Uᵢ at each of the places [kg^−½].
    shapes: Vec<Vec<DVec3>>,
}

/// A place on the surface.
#[derive(Clone, Copy)]
pub(crate) struct Place {
    pub(crate) index: usize,
    pub(crate) point: DVec3,
    pub(crate) normal: DVec3,
}

impl BakedBody {
    /// With the modes up to a frequency \[Hz\], as the program finds them.
    pub(crate) fn new(shape: &str, preset: &Preset, highest: f64) -> BakedBody {
        let material = preset.material();
        let mesh = Shape::parse(shape).unwrap().mesh();
        let centre = MassProperties::of(&mesh).unwrap().centre_of_mass;
        let geometry = BakeGeometry::of_mesh(&mesh.relative_to(centre));
        let constants = ElasticConstants::of(&material).unwrap();
        let mut go_on = |_: &_| ControlFlow::Continue(());
        let options = ModalAnalysisOptions::to(highest);
        let found = modal_analysis(&geometry, &constants, &options, &mut go_on).unwrap();
        let solid = geometry.mass_properties().unwrap();
        let pole = |frequency: f64| {
            let (ratio, omega) = (material.damping.damping_ratio(frequency), TAU * frequency);
            Complex64::new(-ratio * omega, omega * (1.0 - ratio * ratio).sqrt())
        };
        let member = Member {
            inverse_mass: 1.0 / (material.density * solid.volume),
            inverse_inertia: (solid.inertia * material.density).inverse(),
            centre: DVec3::ZERO,
            velocity: DVec3::ZERO,
            angular_velocity: DVec3::ZERO,
            acceleration: DVec3::ZERO,
            poles: found.modes.iter().map(|mode| pole(mode.frequency)).collect(),
            state: Vec::new(),
        };
        // Normals at the corners, weighted by the areas of the triangles.
        let mut normals = vec![DVec3::ZERO; found.surface.nodes.len()];
        for triangle in &found.surface.triangles {
            let corners = [0, 1, 2].map(|k| triangle[k] as usize);
            let [a, b, c] = corners.map(|k| found.surface.nodes[k]);
            corners.iter().for_each(|k| normals[*k] += (b - a).cross(c - a));
        }
        let corners = || normals.iter().enumerate().filter(|(_, normal)| **normal != DVec3::ZERO);
        let place = |(index, (node, normal)): (usize, (usize, &DVec3))| Place {
            index,
            point: found.surface.nodes[node],
            normal: normal.normalize(),
        };
        BakedBody {
            member,
            highest: found.max_frequency,
            places: corners().enumerate().map(place).collect(),
            shapes: corners().map(|(node, _)| found.modes.iter().map(|m| m.shape[node]).collect()).collect(),
            material,
        }
    }

    /// The place where `height` is greatest.
    pub(crate) fn top(&self, height: impl Fn(&Place) -> f64) -> Place {
        *self.places.iter().max_by(|a, b| height(a).total_cmp(&height(b))).unwrap()
    }

    /// Uᵢ at a place [kg^−½].
    pub(crate) fn shapes(&self, place: Place) -> Vec<DVec3> {
        self.shapes[place.index].clone()
    }

    /// 1/m [1/kg] of the rigid body at a place along a unit vector.
    pub(crate) fn inverse_mass(&self, place: Place, along: DVec3) -> f64 {
        let lever = place.point.cross(along);
        self.member.inverse_mass + lever.dot(self.member.inverse_inertia * lever)
    }

    /// The modes below a frequency \[Hz\] alone, and all turned by a rotation.
    pub(crate) fn turned_below(mut self, turn: DMat3, frequency: f64) -> BakedBody {
        let count = self.member.poles.iter().filter(|pole| pole.norm() < TAU * frequency).count();
        self.member.poles.truncate(count);
        self.member.inverse_inertia = turn * self.member.inverse_inertia * turn.transpose();
        for place in &mut self.places {
            (place.point, place.normal) = (turn * place.point, turn * place.normal);
        }
        for shapes in &mut self.shapes {
            shapes.truncate(count);
            shapes.iter_mut().for_each(|shape| *shape = turn * *shape);
        }
        self
    }
}

/// k of F = k d^{3/2} [N/m^1.5] of a ball of a radius \[m\] on a flat body.
pub(crate) fn stiffness(radius: f64, materials: [&Material; 2]) -> f64 {
    let compliance: f64 = materials.iter().map(|material| material.contact_compliance()).sum();
    4.0 / 3.0 * radius.sqrt() / compliance
}

pub(crate) fn steel() -> Material {
    STEEL.material()
}

/// Lets a member stand at rest on contacts of equal load \[N\]: modes and gaps are those of the load.
pub(crate) fn stand(member: &mut Member, side: usize, contacts: &mut [&mut MemberContact], load: f64) {
    let sign = if side == 0 { 1.0 } else { -1.0 };
    let deflection = |mode: usize| -> f64 {
        let along = contacts.iter().map(|c| sign * c.shapes[side][mode].dot(c.normal)).sum::<f64>();
        load * along / member.poles[mode].norm_sqr()
    };
    let deflections: Vec<f64> = (0..member.poles.len()).map(deflection).collect();
    member.state = member.poles.iter().zip(&deflections).map(|(pole, q)| -pole.conj() * *q).collect();
    for contact in contacts {
        let ContactLaw::Hertz(law) = contact.law else { continue };
        let shapes = contact.shapes[side].iter().zip(&deflections);
        let opening: f64 = shapes.map(|(shape, q)| sign * shape.dot(contact.normal) * q).sum();
        contact.gap = -(load / law.stiffness).powf(2.0 / 3.0) - opening;
        contact.standing = true;
    }
}
