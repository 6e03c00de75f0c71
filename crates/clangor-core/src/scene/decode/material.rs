//! The sections `[material.NAME]`: a material defined by the user, or a preset with some numbers changed.

use super::reader::{Decoder, Node, Quantity, Section};
use crate::material::{Damping, Material, presets};
use crate::quantity::{
    DENSITY, FRACTURE_ENERGY, FRICTION, MODULUS, POISSON, RESTITUTION, RESTITUTION_SPEED, ROLLING_LOSS,
    STRENGTH,
};
use crate::scene::diagnostic::{Doubt, Problem};
use crate::scene::simulation_description::ContactModel;

pub(super) const KEYS: &[&str] = &[
    "base",
    "density",
    "youngs_modulus",
    "poisson_ratio",
    "restitution",
    "restitution_speed",
    "yield_strength",
    "friction",
    "rolling_loss",
    "loss_factor",
    "t60",
    "rayleigh",
    "mode_t60",
    "tensile_strength",
    "fracture_energy",
    "source",
];

const LOSS_FACTOR: Quantity = Quantity::between(1e-9, 1.0, "");
const T60: Quantity = Quantity::between(1e-6, 1e4, "s");
const FREQUENCY: Quantity = Quantity::between(1.0, 1e6, "Hz");

/// Materials of the scene, in the order of their names; presets follow.
pub(super) struct Materials {
    custom: Vec<(String, Material)>,
    contact: ContactModel,
}

/// The preset of a name, with the restitution that belongs to a model of contact.
fn preset_for(contact: ContactModel, name: &str) -> Option<Material> {
    match contact {
        ContactModel::Compliant => presets::preset(name),
        ContactModel::Rigid => presets::rigid_preset(name),
    }
}

pub(super) fn materials(d: &mut Decoder<'_>, top: &Section<'_>, contact: ContactModel) -> Materials {
    let mut custom = Vec::new();
    let Some(node) = top.get("material") else { return Materials { custom, contact } };
    for (name, node) in Section::of_names(d, &node) {
        if presets::preset(name).is_some() {
            d.error(node.place(d), Problem::PresetName { name: name.to_owned() });
        }
        // A material with errors keeps its name, so that its bodies are not rejected as well.
        let material = material(d, &node, name, contact).unwrap_or_else(|| presets::STEEL.material());
        custom.push((name.to_owned(), material));
    }
    custom.sort_by(|(a, _), (b, _)| a.cmp(b));
    Materials { custom, contact }
}

impl Materials {
    /// Those that the scene defines.
    pub(super) fn into_custom(self) -> Vec<Material> {
        self.custom.into_iter().map(|(_, material)| material).collect()
    }

    /// A preset as the material of a body.
    pub(super) fn preset(&self, preset: &presets::Preset) -> Material {
        match self.contact {
            ContactModel::Compliant => preset.material(),
            ContactModel::Rigid => preset.rigid_material(),
        }
    }

    /// The material that `key` of a section names.
    pub(super) fn named(
        &self,
        d: &mut Decoder<'_>,
        section: &Section<'_>,
        key: &'static str,
    ) -> Option<Material> {
        self.of_node(d, &section.get(key)?)
    }

    /// The material that a text names.
    pub(super) fn of_node(&self, d: &mut Decoder<'_>, node: &Node<'_>) -> Option<Material> {
        let name = node.text(d, "the name of a material in quotes, such as \"steel\"")?;
        let own = self.custom.binary_search_by(|(own, _)| own.as_str().cmp(name)).ok();
        let own = own.map(|at| self.custom[at].1.clone());
        let found = own.or_else(|| preset_for(self.contact, name));
        if found.is_none() {
            let own = self.custom.iter().map(|(name, _)| name.as_str());
            let presets = presets::names().map(|name| -> &str { name });
            d.unknown_name(node.place(d), "material", name, own.chain(presets));
        }
        found
    }
}

fn material(d: &mut Decoder<'_>, node: &Node<'_>, name: &str, contact: ContactModel) -> Option<Material> {
    let section = node.section(d, KEYS)?;
    let base = base(d, &section, contact);
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
    // A restitution without a speed holds at every speed, whatever the base has.
    let of_base = base.as_ref().filter(|_| !section.mentions("restitution"));
    let restitution_speed = section.number(d, "restitution_speed", RESTITUTION_SPEED);
    let restitution_speed = restitution_speed.or(of_base.and_then(|b| b.restitution_speed));
    let rigid_restitution = of_base.and_then(|b| b.rigid_restitution);
    let yield_strength = section.number(d, "yield_strength", STRENGTH);
    let friction = required(d, "friction", FRICTION, base.as_ref().map(|b| b.friction));
    let damping = damping(d, &section, base.as_ref().map(|b| b.damping.clone()));
    if !has_base && !["t60", "rayleigh"].iter().any(|key| section.mentions(key)) {
        section.missing(d, "loss_factor", format!("{}, or t60 in s, or rayleigh", LOSS_FACTOR.expected()));
    }
    let rolling_loss = section.number(d, "rolling_loss", ROLLING_LOSS);
    let tensile_strength = section.number(d, "tensile_strength", STRENGTH);
    let fracture_energy = section.number(d, "fracture_energy", FRACTURE_ENERGY);
    let source = section.text(d, "source", "text in quotes");
    doubt(d, &section, "density", ("a density", "kg/m³"), [1.0, 23_000.0], "1 to 23000");
    doubt(
        d,
        &section,
        "youngs_modulus",
        ("a Young's modulus", "Pa"),
        [1e5, 1.3e12],
        "1e5 to 1.3e12; 1 GPa is 1e9 Pa",
    );
    Some(Material {
        name: name.to_owned(),
        density,
        youngs_modulus,
        poisson_ratio,
        restitution,
        restitution_speed,
        rigid_restitution,
        yield_strength,
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

fn base(d: &mut Decoder<'_>, section: &Section<'_>, contact: ContactModel) -> Option<Material> {
    let node = section.get("base")?;
    let name = node.text(d, "the name of a preset in quotes, such as \"steel\"")?;
    let base = preset_for(contact, name);
    if base.is_none() {
        d.unknown_name(node.place(d), "preset", name, presets::names());
    }
    base
}

fn damping(d: &mut Decoder<'_>, section: &Section<'_>, base: Option<Damping>) -> Option<Damping> {
    section.exclude(d, "t60", "loss_factor", "`loss_factor`");
    section.exclude(d, "rayleigh", "loss_factor", "`loss_factor`");
    section.exclude(d, "rayleigh", "t60", "`t60`");
    let loss_factor = section.get("loss_factor").and_then(|node| {
        constant_or_table(d, &node, LOSS_FACTOR, Damping::LossFactor, Damping::LossFactorTable)
    });
    let t60 =
        section.get("t60").and_then(|node| constant_or_table(d, &node, T60, Damping::T60, Damping::T60Table));
    let whole = loss_factor.or(t60).or_else(|| rayleigh(d, section)).or(base);
    let modes = section.get("mode_t60").and_then(|node| table(d, &node, T60));
    match (modes, whole) {
        (Some(t60), Some(otherwise)) => Some(Damping::Modes { t60, otherwise: Box::new(otherwise) }),
        (_, whole) => whole,
    }
}

/// A number for all frequencies, or rows of a frequency and a number.
fn constant_or_table(
    d: &mut Decoder<'_>,
    node: &Node<'_>,
    quantity: Quantity,
    constant: fn(f64) -> Damping,
    rows: fn(Vec<[f64; 2]>) -> Damping,
) -> Option<Damping> {
    if node.is_array() { table(d, node, quantity).map(rows) } else { node.number(d, quantity).map(constant) }
}

/// Rows `[frequency, value]` in ascending order of frequency.
fn table(d: &mut Decoder<'_>, node: &Node<'_>, quantity: Quantity) -> Option<Vec<[f64; 2]>> {
    let expected = format!("a list of pairs [frequency in Hz, {}]", quantity.expected());
    let elements = node.elements(d, &expected)?;
    if elements.is_empty() {
        d.error(node.place(d), Problem::WrongLength { found: 0, expected });
        return None;
    }
    let mut rows: Vec<[f64; 2]> = Vec::new();
    let mut good = true;
    for element in &elements {
        let pair = element.elements(d, &expected);
        let Some([at, value]) = pair.as_deref() else {
            if let Some(pair) = pair {
                let expected = expected.clone();
                d.error(element.place(d), Problem::WrongLength { found: pair.len(), expected });
            }
            good = false;
            continue;
        };
        let (Some(frequency), Some(value)) = (at.number(d, FREQUENCY), value.number(d, quantity)) else {
            good = false;
            continue;
        };
        if let Some([previous, _]) = rows.last().copied().filter(|row| row[0] >= frequency) {
            d.error(at.place(d), Problem::UnorderedFrequencies { frequency, previous });
            good = false;
        }
        rows.push([frequency, value]);
    }
    good.then_some(rows)
}

fn rayleigh(d: &mut Decoder<'_>, section: &Section<'_>) -> Option<Damping> {
    let section = section.get("rayleigh")?.section(d, &["alpha", "beta", "g"])?;
    if !["beta", "g"].iter().any(|key| section.mentions(key)) {
        section.missing(d, "alpha", "the damping of the mass in 1/s, or beta in s, or g in 1/s³");
    }
    let mut number =
        |key, high, unit| section.number(d, key, Quantity::between(0.0, high, unit)).unwrap_or(0.0);
    let alpha = number("alpha", 1e6, "1/s");
    let beta = number("beta", 1.0, "s");
    let g = number("g", 1e18, "1/s³");
    Some(Damping::Rayleigh { alpha, beta, g })
}

/// Warns of a number outside the range of real solids, most often a mistake in the unit.
fn doubt(
    d: &mut Decoder<'_>,
    section: &Section<'_>,
    key: &'static str,
    (what, unit): (&'static str, &'static str),
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
