//! Hand-written contact lists: both formats say the same, mistakes are told by line and column, nothing
//! panics.

use std::fs;
use std::path::PathBuf;

use clangor_core::body::BodyId;
use clangor_core::timeline::{ContactKind, ContactRow};
use clangor_pipeline::formats::contact_list::{ContactListError, read_contact_list};
use clangor_pipeline::formats::named_bodies::NamedBodies;
use glam::DVec3;
use proptest::prelude::*;
use tempfile::TempDir;

const NAMES: [&str; 4] = ["die", "big, round ball", "say \"hi\"", "floor"];

fn read_text(name: &str, text: impl AsRef<[u8]>) -> Result<Vec<ContactRow>, ContactListError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, text).unwrap();
    read_contact_list(&path, &NamedBodies::new(NAMES))
}

#[test]
fn both_formats_say_the_same() {
    let csv = "\u{FEFF}# impacts by hand\n\
        t, body_a, body_b, point_x,point_y,point_z, normal_x,normal_y,normal_z, impulse_n, speed, impact_id\n\
        0.5,\"big, round ball\",\"say \"\"hi\"\"\",1,2,3,0,2,0,0.25,1.5,7\r\n\
        \n\
        0.25, die,,0,0,0,0,0,-1,1e-3,0.1,\n";
    let jsonl = concat!(
        "\n",
        r#"{"t": 0.5, "body_a": "big, round ball", "body_b": 2, "point": [1, 2, 3], "normal": [0, 2, 0], "#,
        r#""impulse_n": 0.25, "speed": 1.5, "impact_id": 7}"#,
        "\n# a comment\n",
        r#"{"t": 0.25, "body_a": 0, "kind": "impact", "point": [0, 0, 0], "normal": [0, 0, -1], "#,
        r#""impulse_n": 1e-3, "velocity": [0, 0, 0.1]}"#
    );
    let rows = read_text("a.csv", csv).unwrap();
    assert_eq!(rows, read_text("a.jsonl", jsonl).unwrap());
    // Sorted, the normal made a unit vector, the second impact numbered after the largest number.
    assert_eq!(rows.iter().map(|r| (r.time, r.impact_id)).collect::<Vec<_>>(), [(0.25, 8), (0.5, 7)]);
    let late = rows[1];
    assert_eq!((late.body_a, late.body_b, late.kind), (BodyId(1), BodyId(2), ContactKind::Impact));
    assert_eq!((late.normal, late.velocity), (DVec3::Y, DVec3::Y * -1.5));
    assert_eq!(late.approach_speed(), 1.5);
    assert_eq!(rows[0].body_b, BodyId::WORLD);
}

#[test]
fn mistakes_are_told_by_line_and_column() {
    let head = "t,body_a,point_x,point_y,point_z,normal_x,normal_y,normal_z,impulse_n,speed\n";
    let csv = [
        ("a,b\n".to_string(), "line 1: column a is unknown"),
        (
            head.replacen("t,", "Time,", 1),
            "line 1: column Time is unknown; docs/format/timeline.md lists the columns; if Time is meant as \
             t, rename it",
        ),
        (head.replace("impulse_n", "Impulse_N"), "lists the columns; rename Impulse_N to impulse_n"),
        (head.replace("speed", "sped"), "lists the columns; if sped is meant as speed, rename it"),
        (
            format!("{}0,die,0,0,0,0,1,0,1\n", head.replace(",impulse_n", "")),
            "line 2: impulse_n is missing: there are t, body_a, point_x,",
        ),
        ("t,t\n".into(), "line 1: column t comes twice"),
        (format!("{head}0,die,0,0,0,0,1,0,1\n"), "line 2: there are 9 values, but the header has 10 columns"),
        (format!("{head}\n# x\n0,die,0,0,zero,0,1,0,1,1\n"), "line 4: point_z is zero, not a finite number"),
        (format!("{head}NaN,die,0,0,0,0,1,0,1,1\n"), "line 2: t is NaN, not a finite number"),
        (format!("{head}0,die,0,0,0,0,1,0,inf,1\n"), "line 2: impulse_n is inf, not a finite number"),
        (
            format!("{head}0,dice,0,0,0,0,1,0,1,1\n"),
            "line 2: body_a is dice, which is neither the name nor the number of a body; did you mean die?",
        ),
        (format!("{head}0,4,0,0,0,0,1,0,1,1\n"), "line 2: body_a is 4, which is neither the name nor"),
        (format!("{head}0,,0,0,0,0,1,0,1,1\n"), "line 2: body_a is missing"),
        (format!("{head}0,die,0,,0,0,1,0,1,1\n"), "line 2: point is missing"),
        (format!("{head}0,die,0,0,0,0,0,0,1,1\n"), "line 2: the normal is zero"),
        (format!("{head}0,die,0,0,0,0,1,0,1,\n"), "line 2: velocity or speed is missing"),
        (format!("{head}0,die,0,0,0,0,1,0,-1,1\n"), "line 2: impulse_n is -1, below 0"),
        (format!("{head}0,die,0,0,0,0,1,0,0,1\n"), "line 2: impulse_n is 0, but an impact has an impulse"),
        (format!("{head}0,\"die,0,0,0,0,1,0,1,1\n"), "line 2: at column 3: the quote is not closed"),
        (format!("{head}0,\"die\" x,0,0,0,0,1,0,1,1\n"), "line 2: at column 9: a comma is expected"),
    ];
    for (text, expected) in csv {
        let message = read_text("a.csv", &text).unwrap_err().to_string();
        assert!(message.contains(expected), "{text}: {message}");
    }
    let good = r#"{"t":0,"body_a":"die","point":[0,0,0],"normal":[0,1,0],"impulse_n":1,"speed":1}"#;
    read_text("a.jsonl", good).unwrap();
    let jsonl = [
        ("\"t\":0", "\"t\":\"0\"", "expected f64"),
        ("\"t\":0,", "", "missing field `t`"),
        ("\"t\":0", "\"time\":0", "unknown field `time`"),
        ("\"t\":0", "\"t\":1e999", "number out of range"),
        ("\"die\"", "-1", "expected the name or the number of a body"),
        ("\"die\"", "9", "body_a is 9"),
        ("[0,1,0]", "[0,1]", "invalid length 2"),
        (",\"speed\":1", "", "velocity or speed is missing"),
        ("\"speed\":1", "\"speed\":1,\"kind\":\"hit\"", "kind is hit, none of impact"),
        ("}", "", "EOF while parsing"),
    ];
    for (from, to, expected) in jsonl {
        let text = format!("{good}\n{}", good.replacen(from, to, 1));
        let message = read_text("a.jsonl", &text).unwrap_err().to_string();
        assert!(message.contains("line 2: ") && message.contains(expected), "{text}: {message}");
    }
    assert!(matches!(read_text("a.txt", ""), Err(ContactListError::Extension { .. })));
    assert!(matches!(read_text("a.csv", [b't', 0xFF]), Err(ContactListError::NotText { at: 1, .. })));
    let missing: (TempDir, PathBuf) = (tempfile::tempdir().unwrap(), "none.csv".into());
    let error = read_contact_list(&missing.0.path().join(missing.1), &NamedBodies::default()).unwrap_err();
    assert!(matches!(error, ContactListError::Io { .. }));
    assert_eq!(read_text("a.csv", "").unwrap(), []);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn any_text_is_rows_or_an_error(text in "(t|body_a|speed|normal_x|\"|,|\n\
        |#|[0-9]|\\PC|\\{|:|\\[){0,80}") {
        for name in ["a.csv", "a.jsonl"] {
            for row in read_text(name, &text).unwrap_or_default() {
                prop_assert!(row.time.is_finite() && (row.normal.length() - 1.0).abs() < 1e-12);
            }
        }
    }
}
