//! Tables as other programs write them: numbers of rows, semicolons, decimal commas, tabs, separators of
//! thousands, dates.

use clangor_core::timeline::Timeline;
use clangor_pipeline::formats::timeline_file::TimelineReader;
use parquet::basic::Compression;

use crate::imported_motion::{folder, import, scene};
use crate::parquet_columns::{write_columns, write_decimals, write_no_rows};

const SCENE: &str = scene!();
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

#[test]
fn property_separators_of_thousands_are_refused_with_line_and_number() {
    let semicolons = |text: &str| text.replace(',', ";");
    // Where a value of the third line stands, and in the list too.
    let poses = |value: &str| semicolons(POSES).replace("0.25;ball;0;", &format!("0.25;ball;{value};"));
    let list =
        |value: &str| semicolons(LIST).replace("0.25;ball;floor;0;", &format!("0.25;ball;floor;{value};"));
    for value in ["1,234.5", "1.234,5", "1,234,567", "-1.234.567"] {
        let wanted = format!("line 3: {value} has a separator of thousands");
        for message in [read(&poses(value), LIST).unwrap_err(), read(POSES, &list(value)).unwrap_err()] {
            assert!(message.contains(&wanted), "{message}");
        }
    }
    // The second line has 0.01 and 0.125.
    for (value, other) in [("1,234", "0.01"), ("0,5", "0.01")] {
        let message = read(&poses(value), LIST).unwrap_err();
        assert!(message.contains(&format!("line 3: {value} stands here and {other} in line 2")), "{message}");
    }
    let message = read(POSES, &list("1,234")).unwrap_err();
    assert!(message.contains("line 3: 1,234 stands here and 0.125 in line 2"), "{message}");
    let commas = semicolons(POSES).replace('.', ",").replace("0,5;ball", "0.5;ball");
    let message = read(&commas, LIST).unwrap_err();
    assert!(message.contains("line 4: 0.5 stands here and 0,01 in line 2"), "{message}");
}

#[test]
fn property_names_with_a_comma_or_a_point_are_no_numbers() {
    let scene = SCENE.replace("\"ball\"", "\"1,5\"");
    let poses = POSES.replace(',', ";").replace("ball", "1,5");
    let folder = folder(&scene, &[("a.csv", &poses)]);
    let summary = import(folder.path(), &["a.csv"], &[], false).expect("a body called 1,5");
    assert_eq!(summary.rows.poses, 3);
}

#[test]
fn property_the_index_of_pandas_is_left_out_of_every_format() {
    let expected = read(POSES, LIST).unwrap();
    let csv = |text: &str| numbered(text, &|row| row.to_string()).replacen(',', "__index_level_0__,", 1);
    let vector = |values: &[&str]| format!("[{}]", values.join(","));
    let lines = |text: &str, line: &dyn Fn(&[&str]) -> String| -> String {
        let rows = text.lines().skip(1).enumerate();
        let index = |(row, values): (usize, &str)| {
            let values: Vec<&str> = values.split(',').collect();
            format!("{{\"__index_level_0__\":{row},{}}}\n", line(&values))
        };
        rows.map(index).collect()
    };
    let poses =
        lines(POSES, &|v| format!("\"t\":{},\"body\":\"{}\",\"position\":{}", v[0], v[1], vector(&v[2..5])));
    let list = lines(LIST, &|v| {
        let points = format!("\"point\":{},\"normal\":{}", vector(&v[3..6]), vector(&v[6..9]));
        let head = format!("\"t\":{},\"body_a\":\"{}\",\"body_b\":\"{}\"", v[0], v[1], v[2]);
        format!("{head},{points},\"impulse_n\":{},\"speed\":{}", v[9], v[10])
    });
    let texts = [("a.csv", csv(POSES)), ("b.csv", csv(LIST)), ("a.jsonl", poses), ("b.jsonl", list)];
    let folder = folder(SCENE, &texts.each_ref().map(|(name, text)| (*name, text.as_str())));
    let columns = |text: &str, bodies: &[&str]| -> Vec<(String, Vec<f64>)> {
        let number = |value: &str| match bodies.iter().position(|body| *body == value) {
            Some(body) => body as f64,
            None => value.parse().unwrap(),
        };
        let rows: Vec<Vec<f64>> =
            text.lines().skip(1).map(|line| line.split(',').map(number).collect()).collect();
        let names = text.lines().next().unwrap().split(',').enumerate();
        let column = |(at, name): (usize, &str)| (name.to_string(), rows.iter().map(|row| row[at]).collect());
        let index = ("__index_level_0__".to_string(), (0..rows.len()).map(|row| row as f64).collect());
        names.map(column).chain([index]).collect()
    };
    for (name, text) in [("a.parquet", POSES), ("b.parquet", LIST)] {
        let columns = columns(text, &["ball", "floor"]);
        let columns: Vec<(&str, Vec<f64>)> = columns.iter().map(|(n, v)| (n.as_str(), v.clone())).collect();
        write_columns(&folder.path().join(name), &columns, Compression::UNCOMPRESSED);
    }
    for format in ["csv", "jsonl", "parquet"] {
        let names = [format!("a.{format}"), format!("b.{format}")];
        import(folder.path(), &[&names[0]], &[&names[1]], false).unwrap_or_else(|e| panic!("{e}"));
        let found = TimelineReader::open(&folder.path().join("out.timeline")).unwrap().read_all().unwrap();
        assert_eq!((&found.poses, &found.contacts), (&expected.poses, &expected.contacts), "{format}");
    }
}

#[test]
fn property_dates_in_the_place_of_seconds_are_refused_with_the_remedy() {
    let texts = ["2024-05-01T12:00:00.25Z", "2024-05-01 12:00:00", "0 days 00:00:00.25", "12:00:00.25"];
    for text in texts {
        let dated = |table: &str| table.replace("\n0.25,", &format!("\n{text},"));
        let line = |row: &str| row.replace('T', &format!("\"{text}\""));
        let poses = line("{\"t\":T,\"body\":\"ball\",\"position\":[0,0.01,0]}\n");
        let contacts = line(
            "{\"t\":T,\"body_a\":\"ball\",\"point\":[0,0,0],\"normal\":[0,1,0],\
             \"impulse_n\":1,\"speed\":1}\n",
        );
        let files =
            [("a.csv", POSES), ("x.csv", &dated(POSES)), ("l.csv", &dated(LIST)), ("x.jsonl", &poses)];
        let folder = folder(SCENE, &[&files[..], &[("l.jsonl", &contacts)]].concat());
        let cases: [(&str, &[&str], &str); 4] = [
            ("x.csv", &[], "row 3"),
            ("x.jsonl", &[], "row 1"),
            ("a.csv", &["l.csv"], "line 3"),
            ("a.csv", &["l.jsonl"], "line 1"),
        ];
        for (table, lists, place) in cases {
            let message = import(folder.path(), &[table], lists, false).unwrap_err();
            assert!(message.contains(place) && message.contains(text), "{message}");
            assert!(message.contains("write t as seconds"), "{message}");
        }
    }
}

#[test]
fn property_decimals_of_parquet_are_numbers() {
    let place = ["x", "y", "z"].map(|axis| format!("required double position_{axis};")).concat();
    let types = ["int32 t (DECIMAL(9,3))", "int64 t (DECIMAL(18,3))", "binary t (DECIMAL(30,3))"];
    for time in types.iter().copied().chain(["fixed_len_byte_array(16) t (DECIMAL(38,3))"]) {
        let folder = folder(SCENE, &[]);
        let schema = format!("required {time}; required binary body (UTF8); {place}");
        write_decimals(&folder.path().join("a.parquet"), &schema, &[-250, 0, 250]);
        let message = import(folder.path(), &["a.parquet"], &[], false).unwrap_err();
        assert!(message.contains("t = -0.25 s") || message.contains("-0.25"), "{time}: {message}");
        write_decimals(&folder.path().join("a.parquet"), &schema, &[0, 250, 500]);
        import(folder.path(), &["a.parquet"], &[], false).unwrap_or_else(|error| panic!("{time}: {error}"));
        let timeline = TimelineReader::open(&folder.path().join("out.timeline")).unwrap().read_all().unwrap();
        let last = timeline.poses.iter().map(|row| row.time).fold(0.0, f64::max);
        assert_eq!(last, 0.5, "{time}");
    }
}

#[test]
fn property_columns_of_parquet_with_dates_are_refused_with_the_remedy() {
    let folder = folder(SCENE, &[]);
    let types = [
        "int64 t (TIMESTAMP(NANOS,true))",
        "int64 t (TIMESTAMP_MICROS)",
        "int32 t (TIME(MILLIS,true))",
        "int32 t (DATE)",
        "int96 t",
    ];
    for time in types {
        let path = folder.path().join("a.parquet");
        let place = ["x", "y", "z"].map(|axis| format!("required double position_{axis};")).concat();
        write_no_rows(&path, &format!("required {time}; required int32 body; {place}"));
        let message = import(folder.path(), &["a.parquet"], &[], false).unwrap_err();
        assert!(message.contains("column t holds dates or times"), "{time}: {message}");
        assert!(message.contains("write t as seconds"), "{time}: {message}");
    }
}
