//! What to say of columns that are missing or unknown: which are there, and which of them is spelt otherwise.

use clangor_core::scene::suggest::nearest;

/// Names of columns that are listed at most.
const MOST_NAMES: usize = 24;

/// What other programs call a column.
const OTHER_NAMES: [(&str, &[&str]); 9] = [
    ("t", &["time", "timestamp", "times", "seconds", "sec", "frame"]),
    ("body", &["object", "name", "node"]),
    ("position_x", &["x", "px", "posx", "tx", "locationx", "translatex"]),
    ("position_y", &["y", "py", "posy", "ty", "locationy", "translatey"]),
    ("position_z", &["z", "pz", "posz", "tz", "locationz", "translatez"]),
    ("orientation_x", &["qx", "quatx", "quaternionx"]),
    ("orientation_y", &["qy", "quaty", "quaterniony"]),
    ("orientation_z", &["qz", "quatz", "quaternionz"]),
    ("orientation_w", &["qw", "quatw", "quaternionw"]),
];

/// Beginnings of the names of angles.
const ANGLES: [&str; 4] = ["euler", "roll", "pitch", "yaw"];

/// Whether a column holds an angle about an axis.
fn is_angle(name: &str) -> bool {
    let letters = letters(name);
    let is_about = |own: &str| matches!(letters.strip_prefix(own), Some("x" | "y" | "z"));
    ["r", "rot", "rotate", "rotation"].into_iter().any(is_about)
        || ANGLES.iter().any(|angle| letters.starts_with(angle))
}

/// A name without case, underscores and the like: `Position_X` and `positionX` are `positionx`.
fn letters(name: &str) -> String {
    name.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

/// What to do where a file has `found` instead of `wanted`.
fn remedy(found: &str, wanted: &str) -> String {
    if letters(found) == letters(wanted) {
        return format!("; rename {found} to {wanted}");
    }
    let frames = if letters(found) == "frame" { " and give --time-scale 1/24 for 24 a second" } else { "" };
    format!("; if {found} is meant as {wanted}, rename it{frames}")
}

/// The one of some names that is most likely another.
fn likely<'a>(name: &str, known: impl Iterator<Item = &'a str> + Clone) -> Option<String> {
    let alike = known.clone().find(|other| letters(other) == letters(name)).map(str::to_owned);
    let others = OTHER_NAMES.iter().filter(|(ours, _)| *ours == name).flat_map(|(_, others)| *others);
    let elsewhere = || others.into_iter().find_map(|other| known.clone().find(|n| letters(n) == *other));
    alike.or_else(|| elsewhere().map(str::to_owned)).or_else(|| nearest(name, known))
}

/// Names in a line.
pub(crate) fn listed<'a>(names: impl ExactSizeIterator<Item = &'a str>) -> String {
    let count = names.len();
    let shown: Vec<&str> = names.take(MOST_NAMES).collect();
    let more = if count > shown.len() { format!(" and {} more", count - shown.len()) } else { String::new() };
    format!("{}{more}", shown.join(", "))
}

/// Of a column that a file with these names lacks: the names, and the remedy.
pub(crate) fn instead_of<'a>(
    missing: &str,
    names: impl ExactSizeIterator<Item = &'a str> + Clone,
    unknown: impl Iterator<Item = &'a str> + Clone,
) -> String {
    let remedy = likely(missing, unknown).map_or_else(String::new, |found| remedy(&found, missing));
    format!("there are {}{remedy}", listed(names))
}

/// Of a column that means nothing: the remedy, if a known one that is `free` is likely meant.
pub(crate) fn meant<'a>(name: &str, free: impl Iterator<Item = &'a str> + Clone) -> String {
    if is_angle(name) {
        return "; angles must become quaternions: orientation_x, _y, _z and _w, with the scalar in _w"
            .into();
    }
    let ours = OTHER_NAMES.iter().find(|(_, others)| others.contains(&letters(name).as_str()));
    let ours = ours.map(|(ours, _)| *ours).filter(|ours| free.clone().any(|known| known == *ours));
    ours.map(str::to_owned)
        .or_else(|| likely(name, free))
        .map_or_else(String::new, |wanted| remedy(name, &wanted))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_differ_in_spelling_are_told() {
        let names = ["Time", "body", "Position_X"];
        let of = |missing: &str| instead_of(missing, names.into_iter(), names.into_iter());
        assert_eq!(of("t"), "there are Time, body, Position_X; if Time is meant as t, rename it");
        assert_eq!(of("position_x"), "there are Time, body, Position_X; rename Position_X to position_x");
        assert_eq!(meant("impulseN", ["t", "impulse_n"].into_iter()), "; rename impulseN to impulse_n");
        assert_eq!(
            meant("impluse_n", ["t", "impulse_n"].into_iter()),
            "; if impluse_n is meant as impulse_n, rename it"
        );
        let short = ["frame", "body", "x", "qw"];
        let of = |missing: &str| instead_of(missing, short.into_iter(), short.into_iter());
        assert!(
            of("position_x").ends_with("; if x is meant as position_x, rename it"),
            "{}",
            of("position_x")
        );
        assert!(of("t").ends_with("rename it and give --time-scale 1/24 for 24 a second"), "{}", of("t"));
        let known = ["t", "position_y", "orientation_w"].into_iter();
        assert_eq!(meant("qw", known.clone()), "; if qw is meant as orientation_w, rename it");
        for angle in ["rx", "Rotation_Z", "euler_y", "yaw"] {
            assert!(meant(angle, known.clone()).contains("quaternions"), "{angle}");
        }
        assert!(!meant("radius", known).contains("quaternions"));
        let many = vec!["a"; 30];
        assert!(listed(many.iter().copied()).ends_with("a, a and 6 more"));
    }
}
