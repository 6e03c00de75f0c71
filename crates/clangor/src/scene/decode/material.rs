//! The sections `[material.NAME]`: a material of the user's own, or a preset with some numbers changed.

use super::reader::{Decoder, Node, Quantity, Section};
use crate::material::{Damping, Material, presets};
use crate::scene::diagnostic::{Doubt, Problem};
use crate::scene::suggest::nearest;

pub(super) const KEYS: &[&str] = &[
    "base",
    "density",
    "youngs_modulus",
    "poisson_ratio",
    "restitution",
    "friction",
    "rolling_loss",
    "loss_factor",
    "t60",
    "tensile_strength",
    "fracture_energy",
    "source",
];

const DENSITY: Quantity = Quantity::between(1e-3, 1e5, "kg/m³");
const MODULUS: Quantity = Quantity::between(1.0, 1e13, "Pa");
// The open interval of isotropic elasticity, a hair inside: at 0.5 a body is incompressible.
const POISSON: Quantity = Quantity::between(-0.999, 0.4999, "");
const RESTITUTION: Quantity = Quantity::between(0.0, 1.0, "");
const FRICTION: Quantity = Quantity::between(0.0, 10.0, "");
const LOSS_FACTOR: Quantity = Quantity::between(1e-9, 1.0, "");

/// Materials of the scene, by name; presets are found behind them.
pub(super) struct Materials {
    custom: Vec<(String, Material)>,
}

pub(super) fn materials(d: &mut Decoder<'_>, top: &Section<'_>) -> Materials {
    let Some(node) = top.get("material") else { return Materials { custom: Vec::new() } };
    let mut custom = Vec::new();
    for (name, node) in Section::of_names(d, &node) {
        if presets::preset(name).is_some() {
            d.error(node.place(d), Problem::PresetName { name: name.to_owned() });
        }
        // A material that failed still has a name, so that its bodies are not refused as well.
        let material = material(d, &node, name).unwrap_or_else(|| presets::STEEL.material());
        custom.push((name.to_owned(), material));
    }
    Materials { custom }
}

impl Materials {
    /// The material that `key` of a section names.
    pub(super) fn named(
        &self,
        d: &mut Decoder<'_>,
        section: &Section<'_>,
        key: &'static str,
    ) -> Option<Material> {
        let node = section.get(key)?;
        let name = node.text(d, "the name of a material in quotes, such as \"steel\"")?;
        let own = self.custom.iter().find(|(own, _)| own == name).map(|(_, material)| material.clone());
        let found = own.or_else(|| presets::preset(name));
        if found.is_none() {
            let own = self.custom.iter().map(|(name, _)| name.clone());
            let known: Vec<String> = own.chain(presets::names().map(str::to_owned)).collect();
            d.error(
                node.place(d),
                Problem::UnknownName {
                    what: "material",
                    name: name.to_owned(),
                    nearest: nearest(name, known.iter().map(String::as_str)),
                    known,
                },
            );
        }
        found
    }
}

fn material(d: &mut Decoder<'_>, node: &Node<'_>, name: &str) -> Option<Material> {
    let section = node.section(d, KEYS)?;
    let base = base(d, &section);
    let has_base = section.mentions("base");
    let required = |d: &mut Decoder<'_>, key: &'static str, quantity: Quantity, from_base: Option<f64>| {
        if !section.has(key) && !has_base {
            section.missing(d, key, format!("{}, or base = \"PRESET\"", quantity.expected()));
        }
        section.number(d, key, quantity).or(from_base).unwrap_or(0.0)
    };
    let density = required(d, "density", DENSITY, base.as_ref().map(|b| b.density));
    let youngs_modulus = required(d, "youngs_modulus", MODULUS, base.as_ref().map(|b| b.youngs_modulus));
    let poisson_ratio = required(d, "poisson_ratio", POISSON, base.as_ref().map(|b| b.poisson_ratio));
    let restitution = required(d, "restitution", RESTITUTION, base.as_ref().map(|b| b.restitution));
    let friction = required(d, "friction", FRICTION, base.as_ref().map(|b| b.friction));
    let damping = damping(d, &section).or(base.as_ref().map(|b| b.damping));
    if !has_base && !section.mentions("t60") {
        section.missing(d, "loss_factor", format!("{}, or t60 in s", LOSS_FACTOR.expected()));
    }
    let rolling_loss = section.number(d, "rolling_loss", Quantity::between(0.0, 1.0, "m"));
    let tensile_strength = section.number(d, "tensile_strength", Quantity::between(1.0, 1e13, "Pa"));
    let fracture_energy = section.number(d, "fracture_energy", Quantity::between(1e-6, 1e9, "J/m²"));
    let source = section.text(d, "source", "text in quotes");
    doubt(d, &section, "density", "a density", "kg/m³", [1.0, 23_000.0], "1 to 23000");
    doubt(
        d,
        &section,
        "youngs_modulus",
        "a Young's modulus",
        "Pa",
        [1e5, 1.3e12],
        "1e5 to 1.3e12; 1 GPa is 1e9 Pa",
    );
    Some(Material {
        name: name.to_owned(),
        density,
        youngs_modulus,
        poisson_ratio,
        restitution,
        friction,
        rolling_loss: rolling_loss.or(base.as_ref().map(|b| b.rolling_loss)).unwrap_or(0.0),
        damping: damping.unwrap_or(Damping::LossFactor(0.0)),
        tensile_strength: tensile_strength.or(base.as_ref().and_then(|b| b.tensile_strength)),
        fracture_energy: fracture_energy.or(base.as_ref().and_then(|b| b.fracture_energy)),
        source: match (source, base) {
            (Some(source), _) => source.to_owned(),
            (None, Some(base)) => format!("scene file, on the preset {}: {}", base.name, base.source),
            (None, None) => "scene file".into(),
        },
    })
}

fn base(d: &mut Decoder<'_>, section: &Section<'_>) -> Option<Material> {
    let node = section.get("base")?;
    let name = node.text(d, "the name of a preset in quotes, such as \"steel\"")?;
    let base = presets::preset(name);
    if base.is_none() {
        let nearest = nearest(name, presets::names());
        let known = presets::names().map(str::to_owned).collect();
        d.error(
            node.place(d),
            Problem::UnknownName { what: "preset", name: name.to_owned(), nearest, known },
        );
    }
    base
}

fn damping(d: &mut Decoder<'_>, section: &Section<'_>) -> Option<Damping> {
    section.exclude(d, "t60", "loss_factor", "`loss_factor`");
    let loss_factor = section.number(d, "loss_factor", LOSS_FACTOR).map(Damping::LossFactor);
    let t60 = section.number(d, "t60", Quantity::between(1e-6, 1e4, "s")).map(Damping::T60);
    loss_factor.or(t60)
}

/// Warns of a number outside the range of real solids, which is most often a slip of units.
fn doubt(
    d: &mut Decoder<'_>,
    section: &Section<'_>,
    key: &'static str,
    what: &'static str,
    unit: &'static str,
    [low, high]: [f64; 2],
    usual: &'static str,
) {
    let Some(node) = section.get(key) else { return };
    if let Some(value) = node.peek_number()
        && value > 0.0
        && !(low..=high).contains(&value)
    {
        d.warn(node.place(d), Doubt::Unusual { what, value, unit, usual });
    }
}
