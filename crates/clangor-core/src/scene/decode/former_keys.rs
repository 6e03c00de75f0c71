//! Keys of the scene format that have been renamed.
//!
//! A former key has the meaning of its replacement, and gives a warning. It is accepted for one version,
//! wherever the new key is accepted.

/// A key that has been renamed.
#[derive(Clone, Copy)]
pub(super) struct FormerKey {
    /// Its former name.
    pub(super) name: &'static str,
    /// The key that replaces it.
    pub(super) replacement: &'static str,
    /// Conflict to report if both keys are present.
    pub(super) conflict: &'static str,
}

const FORMER_KEYS: &[FormerKey] = &[
    FormerKey { name: "sound", replacement: "acceleration", conflict: "`acceleration`, its new name" },
    FormerKey { name: "ringing", replacement: "modal", conflict: "`modal`, its new name" },
];

impl FormerKey {
    /// The former key of this name whose replacement is one of `keys`.
    pub(super) fn of(name: &str, keys: &[&str]) -> Option<Self> {
        FORMER_KEYS.iter().find(|former| former.name == name && keys.contains(&former.replacement)).copied()
    }

    /// The former key that `key` replaces.
    pub(super) fn replaced_by(key: &str) -> Option<Self> {
        FORMER_KEYS.iter().find(|former| former.replacement == key).copied()
    }
}

#[cfg(test)]
mod tests {
    use crate::scene::Scene;
    use crate::scene::diagnostic::{Doubt, Problem};

    /// A scene with lines in its only body and in `[render]`.
    fn text(body: &str, render: &str) -> String {
        format!(
            "version = 1\n[[body]]\nshape = \"die\"\nmaterial = \"steel\"\n{body}\n[render]\n{render}\n\
             [[plane]]\nmaterial = \"granite\"\n[[listener]]\nposition = [1, 1, 1]\n"
        )
    }

    #[test]
    fn a_former_key_means_what_the_new_one_means_and_warns() {
        let cases = [
            (text("sound = \"proxy\"", ""), text("acceleration = \"proxy\"", ""), "body[0].sound", 5),
            (text("ringing = \"none\"", ""), text("modal = \"none\"", ""), "body[0].ringing", 5),
            (text("ringing = true", ""), text("modal = true", ""), "body[0].ringing", 5),
            (text("", "sound = \"sphere\""), text("", "acceleration = \"sphere\""), "render.sound", 7),
        ];
        for (former_text, new_text, field, line) in cases {
            let former = Scene::from_toml(&former_text).unwrap();
            let new = Scene::from_toml(&new_text).unwrap();
            assert_eq!(former.sound_rules(), new.sound_rules(), "{field}");
            assert_eq!(former.render, new.render, "{field}");
            assert!(new.warnings.is_empty(), "{:?}", new.warnings);
            let [warning] = &former.warnings[..] else { panic!("{:?}", former.warnings) };
            assert_eq!((warning.place.field.as_str(), warning.place.line), (field, line));
            let Doubt::FormerKey { former, key } = warning.doubt else { panic!("{warning}") };
            assert!(
                field.ends_with(former) && warning.to_string().contains(&format!("`{key}`")),
                "{warning}"
            );
        }
    }

    #[test]
    fn both_names_at_once_are_an_error() {
        let errors = Scene::from_toml(&text("sound = \"own\"\nacceleration = \"own\"", "")).unwrap_err();
        let [error] = &errors.0[..] else { panic!("{errors}") };
        let Problem::Conflict { key, other } = error.problem else { panic!("{error}") };
        assert!(key == "sound" && other.contains("`acceleration`"), "{error}");
    }

    #[test]
    fn a_former_key_is_unknown_where_its_replacement_is() {
        let errors = Scene::from_toml("version = 1\n[medium]\nsound = \"own\"\n").unwrap_err();
        assert!(matches!(&errors.0[..], [e] if matches!(e.problem, Problem::UnknownKey { .. })), "{errors}");
    }
}
