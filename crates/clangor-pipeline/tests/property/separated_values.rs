//! Separated values as other programs write them: numbers of rows, semicolons, decimal commas, tabs.

use clangor_core::timeline::Timeline;
use clangor_pipeline::formats::timeline_file::TimelineReader;

use crate::imported_motion::{folder, import};

const SCENE: &str = r#"version = 1
[[body]]
name = "ball"
shape = "sphere:0.01"
material = "steel"
position = [0.0, 0.5, 0.0]
[[plane]]
name = "floor"
material = "granite"
[[listener]]
position = [0.3, 0.4, 0.4]
"#;
const POSES: &str =
    "t,body,position_x,position_y,position_z\n0,ball,0,0.01,0\n0.25,ball,0,0.01,0\n0.5,ball,0,0.01,0\n";
const LIST: &str = "t,body_a,body_b,point_x,point_y,point_z,normal_x,normal_y,normal_z,impulse_n,speed\n\
                    0.125,ball,floor,0,0,0,0,1,0,0.0125,0.5\n0.25,ball,floor,0,0,0,0,1,0,0.0125,0.5\n";

fn read(poses: &str, list: &str) -> Result<Timeline, String> {
    let folder = folder(SCENE, &[("a.csv", poses), ("b.csv", list)]);
    import(folder.path(), &["a.csv"], &["b.csv"], false)?;
    Ok(TimelineReader::open(&folder.path().join("out.timeline")).unwrap().read_all().unwrap())
}

/// With a first column that has these values below an empty name.
fn numbered(text: &str, first: &dyn Fn(usize) -> String) -> String {
    let line = |(at, line): (usize, &str)| match at.checked_sub(1) {
        None => format!(",{line}\n"),
        Some(row) => format!("{},{line}\n", first(row)),
    };
    text.lines().enumerate().map(line).collect()
}

#[test]
fn property_other_separators_and_numbers_of_rows_give_the_same_rows() {
    let expected = read(POSES, LIST).unwrap();
    let semicolons = |text: &str| text.replace(',', ";");
    let commas = |text: &str| text.replace(',', ";").replace('.', ",");
    let tabs = |text: &str| text.replace(',', "\t");
    let rows = |text: &str| numbered(text, &|row| row.to_string());
    let windows = |text: &str| format!("\u{feff}{}", commas(&rows(text)).replace('\n', "\r\n"));
    let forms: [&dyn Fn(&str) -> String; 5] = [&semicolons, &commas, &tabs, &rows, &windows];
    for (at, form) in forms.into_iter().enumerate() {
        let found = read(&form(POSES), &form(LIST)).unwrap_or_else(|error| panic!("{at}: {error}"));
        assert_eq!((&found.poses, &found.contacts), (&expected.poses, &expected.contacts), "{at}");
    }
}

#[test]
fn property_columns_without_a_name_are_refused_with_place_and_remedy() {
    let filtered = |text: &str| numbered(text, &|row| (2 * row + 3).to_string());
    for message in [read(&filtered(POSES), LIST).unwrap_err(), read(POSES, &filtered(LIST)).unwrap_err()] {
        assert!(message.contains("line 2") && message.contains("index=False"), "{message}");
    }
    let trailing = |text: &str| text.replace('\n', ",\n");
    for message in [read(&trailing(POSES), LIST).unwrap_err(), read(POSES, &trailing(LIST)).unwrap_err()] {
        assert!(message.contains("of the header has no name"), "{message}");
    }
    let message = read(&POSES.replace("0.25,ball,0,0.01,0", "0.25"), LIST).unwrap_err();
    assert!(message.contains("line 3: there is 1 value, but"), "{message}");
}
