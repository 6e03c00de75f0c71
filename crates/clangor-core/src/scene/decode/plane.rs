//! The list `[[plane]]`, and the planes of it that reflect sound.

use glam::DVec3;

use super::body::material;
use super::material::Materials;
use super::names::{Names, name};
use super::reader::{Decoder, Section};
use super::room::one_wall;
use crate::acoustics::Acoustics;
use crate::propagation::reflecting_plane::MOST_ORDERS;
use crate::propagation::{PlanesError, ReflectingPlane, ReflectingPlanes, WallAbsorption};
use crate::quantity;
use crate::scene::body_description::PlaneDescription;
use crate::scene::diagnostic::{Place, Problem};

pub(super) const KEYS: &[&str] =
    &["name", "point", "normal", "material", "thickness", "thin", "reflects", "absorption"];

/// The planes, of which those that reflect are added to the acoustics.
pub(super) fn planes(
    d: &mut Decoder<'_>,
    top: &Section<'_>,
    materials: &Materials,
    names: &mut Names,
    acoustics: &mut Acoustics,
) -> Vec<PlaneDescription> {
    let (mut planes, mut reflecting, mut places) = (Vec::new(), Vec::new(), Vec::new());
    for (index, section) in top.list(d, "plane", KEYS).into_iter().enumerate() {
        let name = name(d, &section, &format!("plane-{}", index + 1), names);
        let point = section.vector(d, "point", "m").unwrap_or(DVec3::ZERO);
        let normal = match section.get("normal") {
            Some(node) => node.direction(d),
            None => Some(DVec3::Y),
        };
        let material = material(d, &section, materials, None);
        let thickness = section.number(d, "thickness", quantity::THICKNESS);
        let thin = section.boolean(d, "thin").unwrap_or(false);
        let reflects = reflects(d, &section, acoustics);
        if let Some((place, absorption)) = reflects {
            reflecting.extend(normal.map(|normal| ReflectingPlane::through(point, normal, absorption)));
            places.push(place);
        }
        let (Some(normal), Some(material)) = (normal, material) else { continue };
        let place = section.place;
        planes.push(PlaneDescription { name, point, normal, material, thickness, thin, place });
    }
    acoustics.planes = together(d, top, &reflecting, &places);
    planes
}

/// What a plane absorbs, and the place of `reflects`; `None` for a plane that does not reflect.
fn reflects(
    d: &mut Decoder<'_>,
    section: &Section<'_>,
    acoustics: &Acoustics,
) -> Option<(Place, WallAbsorption)> {
    let reflects = section.boolean(d, "reflects").unwrap_or(false);
    let absorption = section.get("absorption").map(|node| (node.place(d), one_wall(d, &node)));
    let node = section.get("reflects").filter(|_| reflects);
    let Some(place) = node.map(|node| node.place(d)) else {
        if let Some((place, _)) = absorption {
            d.error(place, Problem::Needs { key: "absorption", other: "reflects = true" });
        }
        return None;
    };
    if acoustics.room.is_some() {
        let other = "[room], whose walls are all that reflects";
        d.error(place, Problem::Conflict { key: "reflects", other });
        return None;
    }
    let absorption = absorption.map_or(Some(WallAbsorption::even(0.0)), |(_, absorption)| absorption);
    absorption.map(|absorption| (place, absorption))
}

/// The reflecting planes, with the order of their reflections.
fn together(
    d: &mut Decoder<'_>,
    top: &Section<'_>,
    planes: &[ReflectingPlane],
    places: &[Place],
) -> ReflectingPlanes {
    let node = top.get("render").and_then(|render| render.get(d, "reflection_order"));
    let order = node.as_ref().and_then(|node| node.integer(d, 1, i64::from(MOST_ORDERS)));
    if let (Some(node), true) = (&node, places.is_empty()) {
        let other = "a [[plane]] with reflects = true";
        d.error(node.place(d), Problem::Needs { key: "reflection_order", other });
    }
    if planes.len() < places.len() {
        // A normal is missing, which is an error already.
        return ReflectingPlanes::default();
    }
    match ReflectingPlanes::try_new(planes, order.unwrap_or(1) as u32) {
        Ok(planes) => planes,
        Err(error) => {
            let index = match error {
                PlanesError::TooMany { limit, .. } => limit,
                PlanesError::Same { second, .. } => second,
                PlanesError::Place { plane, .. } | PlanesError::Absorption { plane, .. } => plane,
                PlanesError::Order { .. } | PlanesError::AndRoom => 0,
            };
            let place = places.get(index).cloned().unwrap_or_else(|| top.place.clone());
            d.error(place, Problem::Planes(error));
            ReflectingPlanes::default()
        }
    }
}
