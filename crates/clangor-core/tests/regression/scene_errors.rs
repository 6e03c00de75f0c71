//! Bad scenes: every error is found, at its line, column and field, and says what to write instead.

use clangor_core::scene::Scene;
use clangor_core::scene::diagnostic::SceneErrors;

/// Expected error: place (`line:column`), field, words of the message, words of the remedy.
type Expected<'a> = (&'a str, &'a str, &'a str, &'a str);

/// Checks that a scene has exactly these errors, in this order.
#[track_caller]
fn refuse(text: &str, expected: &[Expected<'_>]) {
    let SceneErrors(errors) = Scene::from_toml(text).expect_err(text);
    let found: Vec<String> = errors.iter().map(ToString::to_string).collect();
    assert_eq!(found.len(), expected.len(), "\n{text}\n{}", found.join("\n"));
    for (error, (at, field, message, remedy)) in errors.iter().zip(expected) {
        let context = format!("expected {at}: {field}: {message}; {remedy}\nfound {error}\nin\n{text}");
        assert_eq!(format!("{}:{}", error.place.line, error.place.column), *at, "{context}");
        assert_eq!(error.place.field, *field, "{context}");
        assert!(error.problem.to_string().contains(message), "{context}");
        assert!(!remedy.is_empty() && error.problem.remedy().contains(remedy), "{context}");
        assert!(text.is_char_boundary(error.place.span.start.min(text.len())), "{context}");
    }
}

/// A ball with some given lines.
fn ball(lines: &str) -> String {
    format!("version = 1\n[[body]]\nshape = \"sphere:0.01\"\nmaterial = \"steel\"\n{lines}\n")
}

#[test]
fn version() {
    refuse("", &[("1:1", "", "`version` is missing", "version = 1")]);
    refuse("version = 2", &[("1:11", "version", "version 2 is not supported", "version = 1")]);
    refuse("version = \"1\"", &[("1:11", "version", "this is text", "a whole number")]);
    refuse("version = 1.0", &[("1:11", "version", "this is a number", "a whole number")]);
}

#[test]
fn unknown_keys() {
    refuse("version = 1\ngravty = [0, 0, 0]", &[("2:1", "gravty", "unknown key", "did you mean `gravity`?")]);
    refuse("version = 1\ncolour = 3", &[("2:1", "colour", "unknown key", "accepted here: version, medium")]);
    refuse(
        &ball("velocty = [0, 0, 0]"),
        &[("5:1", "body[0].velocty", "unknown key", "did you mean `velocity`?")],
    );
    // A misspelt key is not reported as missing as well.
    refuse(
        "version = 1\n[[body]]\nshap = \"sphere:1\"\nmaterial = \"steel\"",
        &[("3:1", "body[0].shap", "unknown key", "did you mean `shape`?")],
    );
    refuse(
        "version = 1\n[render]\ncompressor = { treshold_db = -3 }",
        &[("3:16", "render.compressor.treshold_db", "unknown key", "did you mean `threshold_db`?")],
    );
}

#[test]
fn bodies_that_cannot_break() {
    let brittle = "[material.glue]\ndensity = 1000\nyoungs_modulus = 1e9\npoisson_ratio = 0.3\nrestitution = \
        0.5\n\
                   friction = 0.3\nloss_factor = 0.1\n";
    let text = |lines: &str| {
        format!("version = 1\n[[body]]\nshape = \"box:0.1x0.1x0.1\"\nmaterial = \"glue\"\n{lines}\n{brittle}")
    };
    refuse(
        &text("fracture = {}"),
        &[(
            "5:12",
            "body[0].fracture",
            "material \"glue\" has no `tensile_strength`",
            "add `tensile_strength`",
        )],
    );
    refuse(
        &ball("fracture = { seeds = 3 }"),
        &[("5:14", "body[0].fracture.seeds", "unknown key", "did you mean `seed`?")],
    );
    refuse(
        &ball("fracture = { scores = [{ point = [0, 0, 0] }] }"),
        &[("5:24", "body[0].fracture.scores[0]", "`normal` is missing", "a vector that is not zero")],
    );
    refuse(
        &ball("motion = \"fixed\"\nfracture = {}"),
        &[("6:12", "body[0].fracture", "", "keep either `fracture` or a motion that nothing changes")],
    );
}

#[test]
fn wrong_types_and_lengths() {
    refuse(
        &ball("velocity = 3"),
        &[("5:12", "body[0].velocity", "this is a whole number", "an array of 3 numbers in m/s")],
    );
    refuse(
        &ball("velocity = [1, 2]"),
        &[("5:12", "body[0].velocity", "this has 2 elements", "an array of 3 numbers in m/s")],
    );
    refuse(
        &ball("position = [0, \"a\", true]"),
        &[
            ("5:16", "body[0].position[1]", "this is text", "a number in m"),
            ("5:21", "body[0].position[2]", "this is true or false", "a number in m"),
        ],
    );
    refuse(
        "version = 1\n[body]\nshape = \"sphere\"",
        &[("2:1", "body", "this is a table", "a list of tables: [[body]]")],
    );
    refuse("version = 1\nbody = [1]", &[("2:9", "body[0]", "this is a whole number", "a table")]);
    refuse("version = 1\nmedium = 3", &[("2:10", "medium", "this is a whole number", "{ density = ... }")]);
    refuse(&ball("name = 7"), &[("5:8", "body[0].name", "this is a whole number", "a name in quotes")]);
    refuse(
        "version = 1\n[simulation]\nsleep = \"no\"\nduration = 1979-05-27",
        &[
            ("3:9", "simulation.sleep", "this is text", "true or false"),
            ("4:12", "simulation.duration", "this is a date", "a number in s"),
        ],
    );
}

#[test]
fn numbers_out_of_range() {
    refuse(
        &ball("velocity = [nan, inf, -inf]"),
        &[
            ("5:13", "body[0].velocity[0]", "not a finite number", "a number in m/s"),
            ("5:18", "body[0].velocity[1]", "not a finite number", "a number in m/s"),
            ("5:23", "body[0].velocity[2]", "not a finite number", "a number in m/s"),
        ],
    );
    refuse(
        "version = 1\n[material.lead]\nbase = \"copper\"\ndensity = -11340",
        &[(
            "4:11",
            "material.lead.density",
            "-11340 is out of range",
            "a number in kg/m³ from 0.001 to 100000",
        )],
    );
    refuse(
        "version = 1\n[material.m]\nbase = \"steel\"\npoisson_ratio = 0.5\nrestitution = 1.5\nfriction = \
         -0.1\nt60 = 0",
        &[
            ("4:17", "material.m.poisson_ratio", "0.5 is out of range", "from -0.999 to 0.4999"),
            ("5:15", "material.m.restitution", "1.5 is out of range", "from 0 to 1"),
            ("6:12", "material.m.friction", "-0.1 is out of range", "from 0 to 10"),
            ("7:7", "material.m.t60", "0 is out of range", "in s from 1e-6 to 10000"),
        ],
    );
    refuse(
        "version = 1\n[material.m]\nbase = \"steel\"\nrestitution_speed = 0\nyield_strength = -2.5e8",
        &[
            ("4:21", "material.m.restitution_speed", "0 is out of range", "in m/s from 1e-6 to 1000"),
            ("5:18", "material.m.yield_strength", "-2.5e8 is out of range", "in Pa from 1 to 1e13"),
        ],
    );
    refuse(
        "version = 1\n[material.m]\nbase = \"wood\"\nrestitution_speed = \"1\"\nyield_strengh = 4e7",
        &[
            ("4:21", "material.m.restitution_speed", "this is text", "a number in m/s"),
            ("5:1", "material.m.yield_strengh", "unknown key", "did you mean `yield_strength`?"),
        ],
    );
    refuse(
        "version = 1\n[render]\nsample_rate = 4000\nmax_frequency = 30000",
        &[
            ("3:15", "render.sample_rate", "4000 is out of range", "from 8000 to 384000"),
            ("4:17", "render.max_frequency", "30000 is out of range", "from 100 to 24000"),
        ],
    );
    refuse(
        "version = 1\n[simulation]\nduration = 0\nseed = -1\ntime_step = 1",
        &[
            ("3:12", "simulation.duration", "0 is out of range", "from 0.001 to 3600"),
            ("4:8", "simulation.seed", "-1 is out of range", "from 0"),
            ("5:13", "simulation.time_step", "1 is out of range", "from 1e-6 to 0.01"),
        ],
    );
    refuse(
        &ball("position = [1e200, 0, 0]"),
        &[("5:13", "body[0].position[0]", "1e200 is out of range", "from -100000 to 100000")],
    );
    refuse(
        &ball("velocity = [400, 0, 0]"),
        &[("5:12", "body[0].velocity", "not slower than sound", "a lower speed")],
    );
    let [first, last] = ["{ time = 0, position = [0, 1, 0] }", "{ time = 0.1, position = [0, 40, 0] }"];
    refuse(
        &ball(&format!("keyframes = [{first}, {last}]")),
        &[("5:50", "body[0].keyframes[1]", "390 m/s is not slower than sound", "a lower speed")],
    );
    refuse(
        &ball("edge_radius = 0.0"),
        &[("5:15", "body[0].edge_radius", "out of range", "a number in m from 1e-9")],
    );
    refuse(
        "version = 1\n[simulation]\nseed = 99999999999999999999",
        &[("3:8", "simulation.seed", "too large", "a whole number")],
    );
    refuse(
        "version = 1\n[simulation]\nv_min = 1e999",
        &[("3:9", "simulation.v_min", "not a finite number", "from 0 to 1000")],
    );
}

#[test]
fn names() {
    refuse(
        "version = 1\n[[plane]]\nmaterial = \"stel\"\n[[plane]]\nmaterial = \"adamantium\"",
        &[
            ("3:12", "plane[0].material", "no material `stel`", "did you mean `steel`?"),
            ("5:12", "plane[1].material", "no material `adamantium`", "known: steel, copper"),
        ],
    );
    refuse(
        "version = 1\n[material.marble]\nbase = \"granit\"",
        &[("3:8", "material.marble.base", "no preset `granit`", "did you mean `granite`?")],
    );
    refuse(
        "version = 1\n[material.steel]\nbase = \"steel\"",
        &[("2:1", "material.steel", "the name of a preset", "choose another name")],
    );
    refuse(
        "version = 1\n[[plane]]\nname = \"a\"\nmaterial = \"wood\"\n[[plane]]\nname = \"a\"\nmaterial = \
         \"wood\"",
        &[("6:8", "plane[1].name", "already taken on line 3", "a name of its own")],
    );
    // The second copy of `b` has the name of another body.
    refuse(
        "version = 1\n[[body]]\nname = \"b-2\"\nshape = \"sphere\"\nmaterial = \"wood\"\n[[body]]\nname = \
         \"b\"\n\
         shape = \"sphere\"\nmaterial = \"wood\"\npositions = [[0, 1, 0], [0, 2, 0]]",
        &[("6:1", "body[1]", "the name `b-2` is already taken on line 3", "a name of its own")],
    );
    refuse(&ball("name = \"\""), &[("5:8", "body[0].name", "empty", "write a name")]);
    refuse(
        "version = 1\n[simulation]\nsolver = \"sphere\"\n[render]\npulse = \"square\"",
        &[
            ("3:10", "simulation.solver", "no solver `sphere`", "did you mean `spheres`?"),
            ("5:9", "render.pulse", "no pulse `square`", "known: hertz, half-sine, gaussian"),
        ],
    );
    refuse(
        &ball(
            "name = \"ball\"\n[[hang]]\nbody = \"bal\"\nanchor = [0, 1, 0]\n[[spring]]\nbody = \"x\"\nto = \
             \"ball\"\nstiffness = 1",
        ),
        &[
            ("7:8", "hang[0].body", "no body `bal`", "did you mean `ball`?"),
            ("10:8", "spring[0].body", "no body `x`", "known: ball"),
        ],
    );
    // A body with errors of its own is there all the same, as are its copies.
    let door = "version = 1\n[[body]]\nname = \"door\"\nshape = \"box:1x2x0.04\"\nmaterial = \"oakk\"\n\
                [[hinge]]\nbody = \"door\"\npoint = [0, 0, 0]\naxis = [0, 1, 0]\n\
                [[hang]]\nbody = \"door-2\"\noffset = [0, 1, 0]";
    refuse(door, &[("5:12", "body[0].material", "there is no material `oakk`", "known")]);
}

#[test]
fn missing_keys() {
    refuse(
        "version = 1\n[[body]]",
        &[
            ("2:1", "body[0]", "`shape` is missing", "such as \"sphere:0.0075\""),
            ("2:1", "body[0]", "`material` is missing", "such as \"steel\""),
        ],
    );
    refuse(
        "version = 1\n[material.own]\ndensity = 1000",
        &[
            ("2:1", "material.own", "`youngs_modulus` is missing", "a number in Pa"),
            ("2:1", "material.own", "`poisson_ratio` is missing", "a number from -0.999"),
            ("2:1", "material.own", "`restitution` is missing", "base = \"PRESET\""),
            ("2:1", "material.own", "`friction` is missing", "a number"),
            ("2:1", "material.own", "`loss_factor` is missing", "or t60"),
        ],
    );
    refuse("version = 1\n[[listener]]", &[("2:1", "listener[0]", "`position` is missing", "or `preset`")]);
    refuse(
        &ball("[[spring]]\nbody = \"body-1\""),
        &[
            ("5:1", "spring[0]", "`to` is missing", "a point"),
            ("5:1", "spring[0]", "`stiffness` is missing", "N/m"),
        ],
    );
    refuse(
        &ball("[[hinge]]\nbody = \"body-1\"\n[[rope]]\nlength = 1\n[[force]]\nbody = \"body-1\""),
        &[
            ("5:1", "hinge[0]", "`axis` is missing", "direction"),
            ("5:1", "hinge[0]", "`point` is missing", "3 numbers"),
            ("7:1", "rope[0]", "`body` is missing", "name of a body"),
            ("7:1", "rope[0]", "`to` is missing", "a point"),
            ("9:1", "force[0]", "`force` is missing", "`torque`"),
        ],
    );
    refuse(
        &ball("press = 3\n[[joint]]\nbody = \"body-1\""),
        &[
            ("5:9", "body[0].press", "means nothing without `keyframes`", "add `keyframes`"),
            ("6:3", "joint", "unknown key", "did you mean `ball_joint`"),
        ],
    );
    refuse(
        &ball("[[force]]\nbody = \"body-1\"\nforce = [[1, 0, 0, 1], [1, 0, 0, 2]]\nstart = 2\n"),
        &[
            ("7:24", "force[0].force[1]", "times must increase", "sort them"),
            ("8:9", "force[0].start", "", "rows"),
        ],
    );
    refuse(
        &ball(
            "count = 3\n[[body]]\nshape = \"sphere\"\nmaterial = \"wood\"\nplacement = { region = [[0, 0, \
             0], [1, 1, 1]] }",
        ),
        &[
            ("5:9", "body[0].count", "means nothing without `placement`", "add `placement`"),
            ("9:13", "body[1].placement", "means nothing without `count`", "add `count`"),
        ],
    );
}

#[test]
fn settings_that_exclude_each_other() {
    refuse(
        &ball("mesh = \"ball.obj\"\nposition = [0, 1, 0]\norigin = [0, 1, 0]"),
        &[
            ("5:8", "body[0].mesh", "cannot be combined with `shape`", "keep either"),
            ("7:10", "body[0].origin", "cannot be combined with `position`", "keep either"),
        ],
    );
    refuse(
        "version = 1\n[render]\nfull_scale = 1.0\nnormalize = -3.0\nfloor_height = 1.0",
        &[
            ("4:13", "render.normalize", "cannot be combined with `full_scale`", "keep either"),
            ("5:16", "render.floor_height", "means nothing without floor", "add floor = \"rigid\""),
        ],
    );
    refuse(
        "version = 1\n[medium]\ntemperature = 20\nsound_speed = 340",
        &[(
            "3:15",
            "medium.temperature",
            "cannot be combined with `density` and `sound_speed`",
            "keep either",
        )],
    );
    refuse(
        "version = 1\n[material.m]\nbase = \"steel\"\nt60 = 1.0\nloss_factor = 0.1",
        &[("4:7", "material.m.t60", "cannot be combined with `loss_factor`", "keep either")],
    );
    refuse(
        "version = 1\n[material.m]\nbase = \"steel\"\nt60 = [[100, 1], [100, 2], [200]]\nrayleigh = \
         {}\nmode_t60 = []",
        &[
            ("4:19", "material.m.t60[1][0]", "100 Hz follows 100 Hz", "sort the rows"),
            ("4:28", "material.m.t60[2]", "this has 1 elements", "[frequency in Hz, a number in s"),
            ("5:12", "material.m.rayleigh", "cannot be combined with `t60`", "keep either"),
            ("5:12", "material.m.rayleigh", "`alpha` is missing", "1/s"),
            ("6:12", "material.m.mode_t60", "this has 0 elements", "a list of pairs"),
        ],
    );
    refuse(
        &ball("motion = \"fixed\"\nvelocity = [1, 0, 0]"),
        &[("6:12", "body[0].velocity", "a motion that is not \"free\"", "keep either")],
    );
    refuse(
        "version = 1\n[[body]]\npreset = \"pan-table\"\nposition = [0, 1, 0]\nscale = 2",
        &[
            ("4:12", "body[0].position", "cannot be combined with `preset`", "keep either"),
            ("5:9", "body[0].scale", "cannot be combined with `preset`", "keep either"),
        ],
    );
}

#[test]
fn shapes() {
    let shape = |text: &str| format!("version = 1\n[[body]]\nmaterial = \"steel\"\nshape = \"{text}\"");
    let at = "4:9";
    refuse(&shape("spere:1"), &[(at, "body[0].shape", "no shape \"spere\"", "did you mean `sphere`?")]);
    refuse(&shape("sphere:1x2"), &[(at, "body[0].shape", "expected a radius", "as in \"sphere:0.0075\"")]);
    refuse(
        &shape("sphere:-1"),
        &[(at, "body[0].shape", "the radius is -1", "between 0.000001 m and 1000 m")],
    );
    refuse(&shape("sphere:nan"), &[(at, "body[0].shape", "the radius is NaN", "a size in metres")]);
    refuse(&shape("coin:0.01x0.002@5"), &[(at, "body[0].shape", "mesh edge @5", "another edge length")]);
    refuse(&shape("sphere:5000"), &[(at, "body[0].shape", "the radius is 5000", "a size in metres")]);
    refuse(
        &shape("rock:{n}x0.01"),
        &[(at, "body[0].shape", "`{n}` means nothing", "`count` or `positions`")],
    );
    refuse(&shape("sphere:1\"\nscale = \"mm"), &[("5:9", "body[0].scale", "this is text", "above 0")]);
    refuse(
        &shape("sphere:1\"\nscale = [1, 2]\nname = \"x"),
        &[("5:9", "body[0].scale", "means nothing without `count`", "add `count` or `positions`")],
    );
    refuse(
        "version = 1\n[[body]]\nmaterial = \"steel\"\nmesh = \"\"",
        &[("4:8", "body[0].mesh", "the path is empty", "relative to the scene file")],
    );
}

#[test]
fn directions_and_keyframes() {
    refuse(
        "version = 1\n[[plane]]\nmaterial = \"wood\"\nnormal = [0, 0, 0]",
        &[("4:10", "plane[0].normal", "no direction", "not zero")],
    );
    refuse(
        "version = 1\n[[listener]]\nposition = [0, 0, 0]\nfacing = [0, -1, 0]",
        &[("4:10", "listener[0].facing", "no direction", "not vertical")],
    );
    refuse(
        &ball("orientation = { quaternion = [1, 1, 1, 1] }"),
        &[("5:30", "body[0].orientation.quaternion", "2 is out of range", "a unit quaternion")],
    );
    refuse(
        &ball("orientation = { axis = [0, 1, 0] }"),
        &[("5:15", "body[0].orientation", "`degrees` is missing", "degrees")],
    );
    refuse(
        &ball(
            "keyframes = [\n  { time = 1, position = [0, 0, 0] },\n  { time = 1, position = [0, 0, 1] },\n]",
        ),
        &[("7:3", "body[0].keyframes[1]", "1 s follows 1 s", "sort them by time")],
    );
    refuse(&ball("keyframes = []"), &[("5:13", "body[0].keyframes", "0 elements", "an array of tables")]);
}

#[test]
fn placement() {
    let copies = |lines: &str| ball(&format!("count = 5\nplacement = {{ {lines} }}"));
    refuse(&copies("seed = 1"), &[("6:13", "body[0].placement", "`region` is missing", "two corners")]);
    refuse(
        &copies("region = [[0, 1, 0], [1, 0, 1]]"),
        &[("6:25", "body[0].placement.region[0]", "1 is out of range", "the least x, y, z first")],
    );
    refuse(
        &copies("region = [[0, 1, 0]]"),
        &[("6:24", "body[0].placement.region", "1 elements", "two corners")],
    );
    refuse(
        &ball("count = 200000\nplacement = { region = [[0, 0, 0], [1, 1, 1]] }"),
        &[("5:9", "body[0].count", "200000 is out of range", "from 1 to 100000")],
    );
    let half = "count = 60000\nplacement = { region = [[0, 0, 0], [1, 1, 1]] }";
    refuse(
        &ball(&format!("{half}\n[[body]]\nshape = \"sphere\"\nmaterial = \"wood\"\n{half}")),
        &[("7:1", "body[1]", "the scene has 120000 bodies", "at most 100000")],
    );
}

#[test]
fn a_listener_below_the_rigid_floor() {
    refuse(
        "version = 1\n[render]\nfloor = \"rigid\"\nfloor_height = 0.4\n[[listener]]\nposition = [0, 0.3, 0]",
        &[("5:1", "listener[0]", "height 0.3 m is below the rigid floor at 0.4 m", "raise the listener")],
    );
}

#[test]
fn endless_plates() {
    let plate = |lines: &str| format!("version = 1\n[[plane]]\nmaterial = \"wood\"\n{lines}");
    let field = "plane[0].thickness";
    for thickness in ["-0.02", "0", "20"] {
        let message = format!("{thickness} is out of range");
        refuse(
            &plate(&format!("thickness = {thickness}")),
            &[("4:13", field, &message, "in m from 1e-5 to 10")],
        );
    }
    refuse(&plate("thickness = \"thin\""), &[("4:13", field, "this is text", "number")]);
    refuse(&plate("thicknes = 0.02"), &[("4:1", "plane[0].thicknes", "unknown key", "`thickness`")]);
}

#[test]
fn reflecting_planes() {
    let plane = |lines: &str| format!("version = 1\n[[plane]]\nmaterial = \"granite\"\n{lines}");
    refuse(
        &plane("absorption = 0.1"),
        &[("4:14", "plane[0].absorption", "`absorption` means nothing", "add reflects = true")],
    );
    refuse(
        &plane("reflects = true\nabsorption = 1.5"),
        &[("5:14", "plane[0].absorption", "1.5 is out of range", "from 0 to 1")],
    );
    refuse(
        &plane("reflects = true\nabsorption = [0.1, 0.2]"),
        &[("5:14", "plane[0].absorption", "2 elements", "an array of 7 numbers")],
    );
    refuse(&plane("reflects = 1"), &[("4:12", "plane[0].reflects", "a whole number", "true or false")]);
    refuse(
        &plane("reflects = true\n[room]\nlowest = [0, 0, 0]\nhighest = [1, 1, 1]\nabsorption = 0.1"),
        &[("4:12", "plane[0].reflects", "cannot be combined with [room]", "keep either `reflects`")],
    );
    refuse(
        &plane("[render]\nreflection_order = 2"),
        &[("5:20", "render.reflection_order", "means nothing without a [[plane]]", "reflects = true")],
    );
    refuse(
        &plane("reflects = true\n[render]\nreflection_order = 5"),
        &[("6:20", "render.reflection_order", "5 is out of range", "from 1 to 4")],
    );
    refuse(
        &plane("reflects = true\n[[plane]]\nmaterial = \"wood\"\nnormal = [0, 2, 0]\nreflects = true"),
        &[("8:12", "plane[1].reflects", "plane 1 is the same as reflecting plane 0", "delete `reflects`")],
    );
    let many: String = (1..8)
        .map(|k| format!("[[plane]]\nmaterial = \"wood\"\npoint = [0, -{k}, 0]\nreflects = true\n"))
        .collect();
    refuse(
        &plane(&format!("reflects = true\n{many}")),
        &[("32:12", "plane[7].reflects", "8 planes reflect, and at most 7 may", "let fewer planes reflect")],
    );
}

#[test]
fn syntax_errors_do_not_hide_the_others() {
    refuse("version = ", &[("1:11", "", "not valid TOML", "put text between")]);
    refuse(
        "version = 1\nversion = 1",
        &[("2:1", "", "not valid TOML: duplicate key", "keep one of the two")],
    );
    // Two syntax errors and two of meaning; the unknown body may result from the broken name and is left out.
    refuse(
        "version = 1\n[render]\nbits = \n[[body]]\nshape = \"sphere\"\nmaterial = steel\nvelocty = 3\nscale \
         = -1\n\
         [[hang]]\nbody = \"b\"\nanchor = [0, 0, 0]",
        &[
            ("3:8", "", "not valid TOML", "text between a pair of double quotes"),
            ("6:12", "", "not valid TOML", "text between a pair of double quotes"),
            ("7:1", "body[0].velocty", "unknown key", "did you mean `velocity`?"),
            ("8:9", "body[0].scale", "-1 is out of range", "above 0"),
        ],
    );
    refuse("version = 1\n[[body]\n", &[("2:8", "", "not valid TOML", "close")]);
    let numbers = [(".2", 15), ("-.2", 15), ("1.", 17), ("01", 15), ("+-3", 16), ("1e", 17)];
    for (number, column) in numbers {
        let at = format!("2:{column}");
        let text = format!("version = 1\ngravity = [0, {number}, 0]\n");
        refuse(&text, &[(&at, "", "not valid TOML", "write a number as 12, -0.5 or 1.2e-3")]);
    }
    refuse("version = 1\ngravity = [0, 1, 0", &[("2:19", "", "not valid TOML", "close the array")]);
}

#[test]
fn columns_count_characters_and_spans_bytes() {
    let text = "version = 1\nbody = [{ name = \"Glöckchen №1\", shap = 3 }]";
    let SceneErrors(errors) = Scene::from_toml(text).unwrap_err();
    let error = errors.iter().find(|e| e.place.field == "body[0].shap").unwrap();
    assert_eq!((error.place.line, error.place.column), (2, 34));
    assert_eq!(&text[error.place.span.clone()], "shap");
    // Far into a long line, past many blocks of the column counter.
    let long = format!("version = 1 # é\nmedium = {{ a = \"{}\", b = 1 }}", "é".repeat(5000));
    let SceneErrors(errors) = Scene::from_toml(&long).unwrap_err();
    let places: Vec<_> = errors.iter().map(|e| (e.place.line, e.place.column)).collect();
    assert_eq!(places, [(2, 12), (2, 5020)]);
}

#[test]
fn every_error_of_a_thoroughly_bad_scene_is_reported_in_order() {
    let text = "\
version = 3
gravity = [0, -9.81]
[medium]
density = -1
[material.a]
bas = \"steel\"
[simulation]
solver = \"magic\"
[render]
bits = 16
[[body]]
shape = \"sphere:0\"
material = \"b\"
[[plane]]
normal = [0, 0, 0]
material = \"a\"
[[listener]]
position = [0, 0]
";
    let SceneErrors(errors) = Scene::from_toml(text).unwrap_err();
    let lines: Vec<usize> = errors.iter().map(|e| e.place.line).collect();
    let expected = [1, 2, 4, 6, 8, 10, 12, 13, 15, 18];
    assert_eq!(lines, expected, "{}", SceneErrors(errors));
}
