//! `KHR_physics_rigid_bodies` (draft of Khronos, <https://github.com/eoineoineoin/glTF_Physics>): masses,
//! what moves a node, and how it meets others.
//!
//! Read are `motion` (mass, centre of mass, inertia, `isKinematic`), the shape of `collider`, and
//! restitution and dynamic friction of its physics material. A mass of 0 means infinity, as the draft says.
//! How the values of two materials combine is ours. Filters and triggers have no sound. Joints and
//! velocities are not read: a recorded motion has them.

use clangor_core::quantity;
use glam::{DMat3, DQuat, DVec3};
use serde_json::Value;

use crate::formats::mesh_reader::gltf::document::{Document, Node};

/// What the extension says of a node.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NodePhysics {
    /// Mass \[kg\], positive and finite.
    pub mass: Option<f64>,
    /// Inertia about the centre of mass, in the axes of the node [kg m²].
    pub inertia: Option<DMat3>,
    /// Whether it is moved from outside (`isKinematic`, or an infinite mass), and so no impact moves it.
    pub is_kinematic: bool,
    /// Centre of mass in the frame of the node \[m\], with its scale.
    pub centre_of_mass: Option<DVec3>,
    /// Whether it has a joint.
    pub has_joint: bool,
    /// Whether it is a body by itself (`motion`).
    pub has_motion: bool,
    /// Index of its implicit shape.
    pub shape: Option<usize>,
    /// Coefficient of restitution, from 0 to 1.
    pub restitution: Option<f64>,
    /// Coefficient of friction.
    pub friction: Option<f64>,
    /// Name of its physics material.
    pub material: Option<String>,
}

/// A value that no body has.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("its {property} in KHR_physics_rigid_bodies is {found}; it must be {expected}")]
pub struct PhysicsFault {
    /// Which.
    pub property: &'static str,
    /// What is there.
    pub found: String,
    /// What may be there.
    pub expected: &'static str,
}

impl NodePhysics {
    pub(super) fn of_node(document: &Document, node: &Node) -> Result<Self, PhysicsFault> {
        let Some(physics) = &node.extensions.physics else { return Ok(NodePhysics::default()) };
        let motion = physics.get("motion");
        let of_motion = |name: &str| motion.and_then(|motion| motion.get(name));
        let mass = number(of_motion("mass"), "mass", 0.0..=f64::MAX, "at least 0 kg")?;
        let collider = physics.get("collider");
        // Older drafts have the shape without a geometry around it.
        let shape = collider.and_then(|collider| collider.get("geometry").unwrap_or(collider).get("shape"));
        let material = collider.and_then(|collider| collider.get("physicsMaterial")?.as_u64());
        let material = material.map(|index| physics_material(document, index)).transpose()?;
        let of_material = |name: &str| material.and_then(|material| material.get(name));
        Ok(NodePhysics {
            mass: mass.filter(|mass| *mass > 0.0),
            inertia: inertia(of_motion("inertiaDiagonal"), of_motion("inertiaOrientation"))?,
            is_kinematic: of_motion("isKinematic").and_then(Value::as_bool) == Some(true)
                || mass == Some(0.0),
            centre_of_mass: of_motion("centerOfMass").map(centre_of_mass).transpose()?,
            has_joint: physics.get("joint").is_some(),
            has_motion: motion.is_some(),
            shape: shape.and_then(Value::as_u64).and_then(|index| usize::try_from(index).ok()),
            restitution: number(of_material("restitution"), "restitution", 0.0..=1.0, "from 0 to 1")?,
            friction: number(of_material("dynamicFriction"), "dynamicFriction", 0.0..=10.0, "from 0 to 10")?,
            material: of_material("name").and_then(Value::as_str).map(ToString::to_string),
        })
    }
}

fn physics_material(document: &Document, index: u64) -> Result<&Value, PhysicsFault> {
    let materials = document.extensions.physics.as_ref().and_then(|physics| physics.get("physicsMaterials"));
    let found = usize::try_from(index).ok().and_then(|index| materials?.get(index));
    found.ok_or_else(|| PhysicsFault {
        property: "physicsMaterial",
        found: index.to_string(),
        expected: "the number of a physics material of the file",
    })
}

fn number(
    value: Option<&Value>,
    property: &'static str,
    range: std::ops::RangeInclusive<f64>,
    expected: &'static str,
) -> Result<Option<f64>, PhysicsFault> {
    let Some(value) = value else { return Ok(None) };
    match value.as_f64().filter(|number| range.contains(number)) {
        Some(number) => Ok(Some(number)),
        None => Err(PhysicsFault { property, found: value.to_string(), expected }),
    }
}

fn centre_of_mass(value: &Value) -> Result<DVec3, PhysicsFault> {
    let point: Option<[f64; 3]> = serde_json::from_value(value.clone()).ok();
    let point = point.filter(|point| point.iter().all(|x| quantity::Quantity::coordinate("m").admits(*x)));
    let expected = "three numbers in metres";
    let fault = || PhysicsFault { property: "centerOfMass", found: value.to_string(), expected };
    point.map(DVec3::from_array).ok_or_else(fault)
}

/// R diag(I) Rᵀ; `None` where the file has none, or it is infinite.
fn inertia(diagonal: Option<&Value>, orientation: Option<&Value>) -> Result<Option<DMat3>, PhysicsFault> {
    let Some(diagonal) = diagonal else { return Ok(None) };
    let fault =
        |property, value: &Value, expected| PhysicsFault { property, found: value.to_string(), expected };
    let moments: Option<[f64; 3]> = serde_json::from_value(diagonal.clone()).ok();
    let [a, b, c] = moments
        .filter(|moments| moments.iter().all(|moment| *moment >= 0.0))
        .ok_or_else(|| fault("inertiaDiagonal", diagonal, "three moments of at least 0 kg m²"))?;
    if a * b * c == 0.0 {
        return Ok(None);
    }
    if a > b + c || b > c + a || c > a + b {
        return Err(fault(
            "inertiaDiagonal",
            diagonal,
            "moments of which none exceeds the sum of the others",
        ));
    }
    let turn = match orientation {
        None => DQuat::IDENTITY,
        Some(value) => {
            let quaternion: Option<[f64; 4]> = serde_json::from_value(value.clone()).ok();
            let quaternion = quaternion.map(DQuat::from_array).filter(|q| q.length_squared() > 0.0);
            quaternion.ok_or_else(|| fault("inertiaOrientation", value, "a quaternion"))?.normalize()
        }
    };
    let rotation = DMat3::from_quat(turn);
    Ok(Some(rotation * DMat3::from_diagonal(DVec3::new(a, b, c)) * rotation.transpose()))
}
