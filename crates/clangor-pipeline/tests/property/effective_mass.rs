//! Effective masses in tables and contact lists: what is written, read, refused, and taken for none.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use clangor_core::timeline::{ContactKind, ContactRow, Timeline};
use clangor_pipeline::formats::contact_list::{ContactListError, read_contact_list};
use clangor_pipeline::formats::named_bodies::NamedBodies;
use clangor_pipeline::formats::timeline_file::{RowProblem, TimelineError, TimelineReader, TimelineWriter};
use clangor_pipeline::interchange::body_files::{ListedMotion, import_contacts};
use clangor_pipeline::stages::load::load_scene;
use parquet::basic::{Compression, Repetition};
use parquet::column::reader::ColumnReader;
use parquet::column::writer::ColumnWriter;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use crate::parquet_columns::write_columns;
use crate::timelines::{example, header, read, recorded, row, write};

fn impact(time: f64, effective_mass: Option<f64>) -> ContactRow {
    ContactRow { kind: ContactKind::Impact, impact_id: 1, effective_mass, ..row(time) }
}

fn column_names(path: &Path) -> Vec<String> {
    let file = SerializedFileReader::new(fs::File::open(path.join("contacts.parquet")).unwrap()).unwrap();
    let schema = file.metadata().file_metadata().schema_descr();
    schema.columns().iter().map(|column| column.name().to_string()).collect()
}

#[test]
fn the_column_is_there_only_for_rows_that_have_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.timeline");
    let none: Vec<ContactRow> = (0..3000).map(|i| impact(f64::from(i) * 1e-3, None)).collect();
    write(&path, &header(), &recorded(none.clone(), vec![])).unwrap();
    let before = fs::read(path.join("contacts.parquet")).unwrap();
    assert_eq!(column_names(&path).len(), 22);
    // With the column asked for and no value in it, the rows are the same.
    let mut writer = TimelineWriter::create_for_contacts(&path, &header(), true, true).unwrap();
    none.iter().for_each(|row| clangor_core::timeline::TimelineSink::contact(&mut writer, row).unwrap());
    writer.finish().unwrap();
    assert_eq!(column_names(&path).last().unwrap(), "effective_mass");
    assert_eq!(read(&path).unwrap().contacts, none);
    // Without it, a value is not lost but refused.
    let mut writer = TimelineWriter::create(&path, &header(), true).unwrap();
    let refused = clangor_core::timeline::TimelineSink::contact(&mut writer, &impact(0.0, Some(1.0)));
    let message = refused.unwrap_err().to_string();
    assert!(message.contains("effective_mass has a value, but the table was created without"), "{message}");
    // Rows of blocks with and without values come back, to 32 bits.
    let some = |i: usize| (i.is_multiple_of(3) && i < 1024 || i == 2999).then_some(0.5 + i as f64);
    let rows: Vec<ContactRow> =
        none.iter().enumerate().map(|(i, row)| ContactRow { effective_mass: some(i), ..*row }).collect();
    write(&path, &header(), &recorded(rows.clone(), vec![])).unwrap();
    assert_eq!(read(&path).unwrap().contacts, rows);
    assert_eq!(column_names(&path).len(), 23);
    // A copy with forces keeps them.
    let copy = folder.path().join("copy.timeline");
    TimelineReader::open(&path).unwrap().copy_with_forces(&[], &copy, false).unwrap();
    assert_eq!(read(&copy).unwrap().contacts, rows);
    write(&path, &header(), &recorded(none, vec![])).unwrap();
    assert_eq!(fs::read(path.join("contacts.parquet")).unwrap(), before);
}

/// Writes the table of contacts again, with a last column of these values, required or optional.
fn add_column(path: &Path, values: &[Option<f32>], repetition: Repetition) {
    let table = path.join("contacts.parquet");
    let old = SerializedFileReader::new(fs::File::open(&table).unwrap()).unwrap();
    let mut fields = old.metadata().file_metadata().schema().get_fields().to_vec();
    let builder = Type::primitive_type_builder("effective_mass", parquet::basic::Type::FLOAT);
    fields.push(Arc::new(builder.with_repetition(repetition).build().unwrap()));
    let schema = Type::group_type_builder("schema").with_fields(fields).build().unwrap();
    let new = table.with_extension("new");
    let mut writer =
        SerializedFileWriter::new(fs::File::create(&new).unwrap(), Arc::new(schema), Arc::default()).unwrap();
    let group = old.get_row_group(0).unwrap();
    let mut rows = writer.next_row_group().unwrap();
    let count = values.len();
    for at in 0..group.num_columns() {
        let mut column = rows.next_column().unwrap().unwrap();
        /// Copies a column of one type.
        macro_rules! copy {
            ($reader:ident, $out:ident) => {{
                let mut values = Vec::new();
                $reader.read_records(count, None, None, &mut values).unwrap();
                $out.write_batch(&values, None, None).unwrap();
            }};
        }
        match (group.get_column_reader(at).unwrap(), column.untyped()) {
            (ColumnReader::DoubleColumnReader(mut r), ColumnWriter::DoubleColumnWriter(w)) => copy!(r, w),
            (ColumnReader::FloatColumnReader(mut r), ColumnWriter::FloatColumnWriter(w)) => copy!(r, w),
            (ColumnReader::Int32ColumnReader(mut r), ColumnWriter::Int32ColumnWriter(w)) => copy!(r, w),
            (ColumnReader::Int64ColumnReader(mut r), ColumnWriter::Int64ColumnWriter(w)) => copy!(r, w),
            _ => panic!("a column of another type"),
        }
        column.close().unwrap();
    }
    let mut column = rows.next_column().unwrap().unwrap();
    let present: Vec<f32> = values.iter().flatten().copied().collect();
    let levels: Vec<i16> = values.iter().map(|value| i16::from(value.is_some())).collect();
    let levels = (repetition == Repetition::OPTIONAL).then_some(&levels[..]);
    let ColumnWriter::FloatColumnWriter(out) = column.untyped() else { panic!("no floats") };
    out.write_batch(&present, levels, None).unwrap();
    column.close().unwrap();
    rows.close().unwrap();
    writer.close().unwrap();
    fs::rename(new, table).unwrap();
    let file = path.join("timeline.json");
    let mut text: serde_json::Value = serde_json::from_str(&fs::read_to_string(&file).unwrap()).unwrap();
    text["contacts"].as_object_mut().unwrap().remove("hash");
    fs::write(&file, text.to_string()).unwrap();
}

#[test]
fn null_nan_and_0_are_none_and_impossible_masses_are_refused_by_row() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.timeline");
    let rows: Vec<ContactRow> = (0..4).map(|i| impact(f64::from(i), None)).collect();
    let with = |values: &[Option<f32>], repetition| -> Result<Timeline, TimelineError> {
        write(&path, &header(), &recorded(rows.clone(), vec![])).unwrap();
        add_column(&path, values, repetition);
        read(&path)
    };
    let masses = |timeline: Timeline| -> Vec<Option<f64>> {
        timeline.contacts.iter().map(|row| row.effective_mass).collect()
    };
    let found = with(&[None, Some(f32::NAN), Some(0.0), Some(0.75)], Repetition::OPTIONAL).unwrap();
    assert_eq!(masses(found), [None, None, None, Some(0.75)]);
    let found = with(&[Some(-0.0), Some(f32::NAN), Some(2.0), Some(0.75)], Repetition::REQUIRED).unwrap();
    assert_eq!(masses(found), [None, None, Some(2.0), Some(0.75)]);
    for bad in [-1.0, f32::INFINITY, f32::NEG_INFINITY, 1e-36, 1e30] {
        for repetition in [Repetition::OPTIONAL, Repetition::REQUIRED] {
            let error = with(&[Some(1.0), Some(1.0), Some(bad), Some(1.0)], repetition).unwrap_err();
            let is_located = matches!(&error, TimelineError::Row {
                row: 2,
                problem: RowProblem::EffectiveMass { value },
                ..
            } if *value == f64::from(bad));
            assert!(is_located, "{error}");
        }
    }
    // What is written is checked as well.
    for bad in [-1.0, 0.0, f64::INFINITY, f64::NAN, 1e-46, 1e39] {
        let rows = vec![impact(0.0, None), impact(1.0, Some(bad))];
        let message = write(&path, &header(), &recorded(rows, vec![])).unwrap_err().to_string();
        assert!(message.contains("contacts.parquet, row 1: effective_mass is"), "{message}");
    }
    // A table without the column is read as before.
    let (_folder, old, timeline) = example();
    assert!(!column_names(&old).contains(&"effective_mass".to_string()));
    assert_eq!(read(&old).unwrap(), timeline);
}

const HEAD: &str =
    "t,body_a,point_x,point_y,point_z,normal_x,normal_y,normal_z,impulse_n,speed,effective_mass\n";

/// Effective masses of a list, or its error.
fn listed(name: &str, text: &str) -> Result<Vec<Option<f64>>, ContactListError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, text).unwrap();
    let rows = read_contact_list(&path, &NamedBodies::new([""]))?;
    Ok(rows.iter().map(|row| row.effective_mass).collect())
}

#[test]
fn lists_of_all_formats_have_it() {
    let line = |time: usize, mass: &str| format!("{time},0,0,0,0,0,1,0,1,1,{mass}\n");
    let masses = ["", "NaN", "0", "0.125"];
    let csv: String = masses.iter().enumerate().map(|(time, mass)| line(time, mass)).collect();
    let wanted = [None, None, None, Some(0.125)];
    assert_eq!(listed("a.csv", &format!("{HEAD}{csv}")).unwrap(), wanted);
    let object = |(time, mass): (usize, &str)| {
        format!(
            "{{\"t\": {time}, \"body_a\": 0, \"point\": [0, 0, 0], \"normal\": [0, 1, 0], \"impulse_n\": 1, \
             \"speed\": 1{mass}}}\n"
        )
    };
    let fields = ["", ", \"effective_mass\": null", ", \"effective_mass\": 0", ", \"effective_mass\": 0.125"];
    let jsonl: String = fields.into_iter().enumerate().map(object).collect();
    assert_eq!(listed("a.jsonl", &jsonl).unwrap(), wanted);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.parquet");
    let mut columns: Vec<(&str, Vec<f64>)> =
        HEAD.trim().split(',').map(|name| (name, vec![0.0; 3])).collect();
    let values =
        [("t", [0.0, 1.0, 2.0]), ("normal_y", [1.0; 3]), ("impulse_n", [1.0; 3]), ("speed", [1.0; 3])];
    for (name, values) in values.into_iter().chain([("effective_mass", [f64::NAN, 0.0, 0.125])]) {
        columns.iter_mut().find(|(column, _)| *column == name).unwrap().1 = values.to_vec();
    }
    write_columns(&path, &columns, Compression::UNCOMPRESSED);
    let rows = read_contact_list(&path, &NamedBodies::new([""])).unwrap();
    assert_eq!(rows.iter().map(|row| row.effective_mass).collect::<Vec<_>>(), wanted[1..]);

    for (mass, expected) in [
        ("-1", "line 3: effective_mass is -1e0; it must be"),
        ("inf", "line 3: effective_mass is inf, not a finite number"),
        ("1e30", "line 3: effective_mass is 1e30; it must be"),
        ("heavy", "line 3: effective_mass is heavy, not a finite number"),
    ] {
        let text = format!("{HEAD}{}{}", line(0, "1"), line(1, mass));
        let message = listed("a.csv", &text).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    }
    let text = object((0, ", \"effective_mass\": -2"));
    let message = listed("a.jsonl", &text).unwrap_err().to_string();
    assert!(message.contains("line 1: effective_mass is -2e0; it must be"), "{message}");
}

#[test]
fn an_imported_list_keeps_it_and_bounds_impulses_by_it() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml");
    let body =
        "[[body]]\nname = \"link\"\nshape = \"sphere:0.02\"\nmaterial = \"steel\"\nposition = [0, 1, 0]\n";
    let ear = "[[listener]]\nposition = [0, 0, 1]\n";
    fs::write(&scene, format!("version = 1\n{body}{ear}")).unwrap();
    let loaded = load_scene(&scene, &|_| ()).unwrap();
    let import = |mass: &str, impulse: f64| {
        let list = folder.path().join("list.csv");
        fs::write(&list, format!("{HEAD}0.1,link,0,0.98,0,0,1,0,{impulse},1,{mass}\n")).unwrap();
        let output = folder.path().join("run.timeline");
        import_contacts(&loaded, &list, ListedMotion::AtRest, &output, true).map(|_| read(&output).unwrap())
    };
    assert_eq!(import("3", 0.1).unwrap().contacts[0].effective_mass, Some(3.0));
    assert_eq!(import("", 0.1).unwrap().contacts[0].effective_mass, None);
    assert!(!column_names(&folder.path().join("run.timeline")).contains(&"effective_mass".into()));
    // A ball of 0.26 kg gives at most ten times m v in all; with 3 kg on joints, it can give more.
    let message = import("", 6.0).unwrap_err().to_string();
    assert!(message.contains("impulse_n on link is 6 N s; the bodies could give no more"), "{message}");
    assert_eq!(import("3", 6.0).unwrap().contacts[0].impulse_n, 6.0);
    assert!(import("3", 60.0).is_err());
}
