//! The exact messages of every class of error: what is replaced, by what, and the answer.

/// What is replaced (once) in the good scene, by what, and the message, without the path of the
/// file.
pub(super) type Damage = (&'static str, &'static str, &'static str);

/// Keys and types that do not exist, or lack.
#[rustfmt::skip]
pub(super) const BAD_KEYS: &[Damage] = &[
    ("reflectance", "reflectence",
        "3:1: unknown key `reflectence` in [materials.walls.lambert]\n  help: did you mean \
         `reflectance`?"),
    ("reflectance", "shininess",
        "3:1: unknown key `shininess` in [materials.walls.lambert]\n  help: the keys here are \
         `reflectance` and `exitance`"),
    ("format = 1\n", "",
        "1:1: missing key `format`\n  help: add `format = 1`"),
    ("format = 1", "format = 2",
        "1:10: format 2 is not known\n  help: this version reads format 1; write `format = 1`, or \
         use the version the scene was made for"),
    ("format = 1", "format = \"1\"",
        "1:10: `format` must be a whole number, found the string \"1\"\n  help: write it without \
         quotes"),
    ("format = 1", "fromat = 1",
        "1:1: unknown key `fromat`\n  help: did you mean `format`?"),
    ("materials.walls.lambert", "materials.walls.lambrt",
        "2:18: unknown type `lambrt` in [materials.walls]\n  help: did you mean `lambert`?"),
    ("materials.walls.lambert", "materials.walls",
        "3:1: unknown type `reflectance` in [materials.walls]\n  help: write \
         [materials.walls.lambert]; the types of materials are: `lambert`, `metal`, `coated`, \
         `mirror` and `mixture`"),
    ("materials.walls.lambert", "material.walls.lambert",
        "2:2: unknown key `material`\n  help: did you mean `materials`?"),
    ("[materials.walls.lambert]", "[demand]\n[materials.walls.lambert]",
        "2:2: unknown key `demand`\n  help: the keys here are `format`, `materials`, `objects`, \
         `lights`, `cameras`, `sensors`, `render`, `illum`, `require` and `compare`"),
    ("min = [0, 0, 0]\n", "",
        "6:1: missing key `min` in [objects.room.box]\n  help: add `min = [0, 0, 0]`"),
    ("z_min = \"floor\"", "z_mni = \"floor\"",
        "11:11: unknown key `z_mni` in [objects.room.box.faces]\n  help: did you mean `z_min`?"),
    ("relative_error = 0.01", "relativ_error = 1",
        "24:10: unknown key `relativ_error` in [render.stop]\n  help: did you mean \
         `relative_error`?"),
    ("[lights.lamp.point]", "[lights]\nlamp = \"point\"\n[x]",
        "13:8: [lights.lamp] must be a table with a type in its header\n  help: write \
         [lights.lamp.point]; the types of lights are: `point`, `lambert` and `spot`"),
    ("[lights.lamp.point]", "[[lights.lamp.point]]",
        "12:1: `point` in [lights.lamp] must be a table\n  help: write [lights.lamp.point]; the \
         types of lights are: `point`, `lambert` and `spot`"),
    ("[lights.lamp.point]", "[lights.empty]\n[lights.lamp.point]",
        "12:1: [lights.empty] has no type\n  help: write [lights.empty.point]; the types of \
         lights are: `point`, `lambert` and `spot`"),
    ("[lights.lamp.point]", "[objects.room.sphere]\n[lights.lamp.point]",
        "12:15: [objects.room] has more than one type: `box` and `sphere`\n  help: a thing has \
         one type; give the other one a name of its own"),
    ("[lights.lamp.point]", "[materials.\"a b\".lamb]\n[lights.lamp.point]",
        "12:18: unknown type `lamb` in [materials.\"a b\"]\n  help: write [materials.\"a \
         b\".lambert]; the types of materials are: `lambert`, `metal`, `coated`, `mirror` and \
         `mixture`"),
];

/// Text that is not TOML.
#[rustfmt::skip]
pub(super) const BAD_TOML: &[Damage] = &[
    ("reflectance = 0.5", "reflectance = 0.5\nreflectance = 0.5",
        "4:1: duplicate key `reflectance`\n  help: it is written twice; keep one of the two"),
    ("reflectance = 0.5", "reflectance = 0.5\n[materials.walls.lambert]",
        "4:18: duplicate key `lambert`\n  help: it is written twice; keep one of the two"),
    ("reflectance = 0.5", "reflectance = walls",
        "3:15: not valid TOML: found `walls`\n  help: words need quotes, numbers a point and no \
         unit"),
    ("reflectance = 0.5", "reflectance = ",
        "3:15: a value is missing behind `=`\n  help: write a number, a word in quotes, or an \
         array"),
    ("reflectance = 0.5", "reflectance 0.5",
        "3:13: not valid TOML: key with no value, expected `=`\n  help: a scene is made of \
         headers such as [lights.lamp.point] and lines such as `intensity = 100`; words need \
         quotes"),
    ("reflectance = 0.5", "reflectance = [0.5",
        "4:1: not valid TOML: missing comma between array elements, expected `,`\n  help: a scene \
         is made of headers such as [lights.lamp.point] and lines such as `intensity = 100`; \
         words need quotes"),
    ("reflectance = 0.5", "reflectance = \"0.5",
        "3:19: not valid TOML: invalid basic string, expected `\"`\n  help: a scene is made of \
         headers such as [lights.lamp.point] and lines such as `intensity = 100`; words need \
         quotes"),
    ("[materials.walls.lambert]", "[materials.walls.lambert",
        "2:25: not valid TOML: unclosed table, expected `]`\n  help: a scene is made of headers \
         such as [lights.lamp.point] and lines such as `intensity = 100`; words need quotes"),
    ("format = 1", "Dies ist kein TOML: äöü",
        "1:6: not valid TOML: key with no value, expected `=`\n  help: a scene is made of headers \
         such as [lights.lamp.point] and lines such as `intensity = 100`; words need quotes"),
];

/// Values of the wrong type or outside their range.
#[rustfmt::skip]
pub(super) const BAD_VALUES: &[Damage] = &[
    ("reflectance = 0.5", "reflectance = \"0.5\"",
        "3:15: `reflectance` in [materials.walls.lambert] must be a number or [r, g, b], found \
         the string \"0.5\"\n  help: write it without quotes"),
    ("reflectance = 0.5", "reflectance = 1",
        "3:15: `reflectance` in [materials.walls.lambert] must be from 0 to below 1, found \
         1\n  help: it is the reflected part of the flux; at 1 light would never be absorbed"),
    ("reflectance = 0.5", "reflectance = -0.1",
        "3:15: `reflectance` in [materials.walls.lambert] must be from 0 to below 1, found \
         -0.1\n  help: it is the reflected part of the flux; at 1 light would never be absorbed"),
    ("reflectance = 0.5", "reflectance = [0.5, 0.5]",
        "3:15: `reflectance` in [materials.walls.lambert] must be an array of 3 numbers, found 2 \
         of them\n  help: write it like `reflectance = 0.5`"),
    ("reflectance = 0.5", "reflectance = [0.5, 0.5, 1.5]",
        "3:26: `reflectance` in [materials.walls.lambert] must be from 0 to below 1, found \
         1.5\n  help: it is the reflected part of the flux; at 1 light would never be absorbed"),
    ("reflectance = 0.5", "reflectance = [0.5, 0.5, \"x\"]",
        "3:26: `reflectance` in [materials.walls.lambert] must be a number, found the string \
         \"x\"\n  help: write it like `reflectance = 0.5`"),
    ("reflectance = 0.5", "reflectance = nan",
        "3:15: `reflectance` in [materials.walls.lambert] must be a finite number, found \
         NaN\n  help: write it like `reflectance = 0.5`"),
    ("reflectance = 0.5", "reflectance = 0.5\nexitance = -1",
        "4:12: `exitance` in [materials.walls.lambert] must be 0 or more, found -1\n  help: write \
         it like `exitance = 100`"),
    ("reflectance = 0.5", "reflectance = 0.5\nexitance = inf",
        "4:12: `exitance` in [materials.walls.lambert] must be a finite number, found \
         inf\n  help: write it like `exitance = 100`"),
    ("min = [0, 0, 0]", "min = [0, 0, 0, 0]",
        "7:7: `min` in [objects.room.box] must be an array of 3 numbers, found 4 of them\n  help: \
         write it like `min = [0, 0, 0]`"),
    ("min = [0, 0, 0]", "min = 0",
        "7:7: `min` in [objects.room.box] must be an array of 3 numbers, found the number \
         0\n  help: write it like `min = [0, 0, 0]`"),
    ("min = [0, 0, 0]", "min = [0, 0, -1e10]",
        "7:14: `min` in [objects.room.box] must be within 1e9 metres of the origin, found \
         -10000000000\n  help: write it like `min = [0, 0, 0]`"),
    ("inward = true", "inward = 1",
        "9:10: `inward` in [objects.room.box] must be true or false, found the number 1\n  help: \
         write it like `inward = true`"),
    ("material = \"walls\"", "material = 3",
        "10:12: `material` in [objects.room.box] must be a string, found the number 3\n  help: \
         write it like `material = \"walls\"`"),
    ("{ z_min = \"floor\" }", "3",
        "11:9: `faces` in [objects.room.box] must be a table, found the number 3\n  help: write \
         it like `faces = { z_min = \"floor\" }`"),
    ("intensity = 100", "intensity = 0",
        "14:13: `intensity` in [lights.lamp.point] must be above 0, found 0\n  help: write it \
         like `intensity = 100`"),
    ("intensity = 100", "intensity = 100\ncolour = [0, 0, 0]",
        "15:10: `colour` in [lights.lamp.point] must have a component above 0\n  help: write the \
         lamp's strength in `intensity` or `flux`"),
    ("fov = 45", "fov = 180",
        "18:7: `fov` in [cameras.main.perspective] must be between 0 and 180 degrees, found \
         180\n  help: write it like `fov = 45`"),
    ("to = [2, 3, 1]", "up = [0, 0, 0]\nto = [2, 3, 1]",
        "17:6: `up` in [cameras.main.perspective] must be a direction, found a vector of length \
         0\n  help: write it like `up = [0, 0, 1]`"),
    ("resolution = [640, 480]", "resolution = [640, 0]",
        "19:20: `resolution` in [cameras.main.perspective] must be a whole number from 1 to \
         65536, found 0\n  help: write it like `resolution = [640, 480]`"),
    ("resolution = [640, 480]", "resolution = [640.5, 480]",
        "19:15: `resolution` in [cameras.main.perspective] must be a whole number from 1 to \
         65536, found 640.5\n  help: write it like `resolution = [640, 480]`"),
    ("on = \"room.z_min\"", "on = \"room.z_min\"\nspacing = \"en12465\"",
        "22:11: `spacing` in [sensors.desk.grid] must be \"en12464\" or a number of metres, found \
         \"en12465\"\n  help: write it like `spacing = \"en12464\"`"),
    ("on = \"room.z_min\"", "on = \"room.z_min\"\nspacing = []",
        "22:11: `spacing` in [sensors.desk.grid] must be \"en12464\" or a number of metres, found \
         an array\n  help: write it like `spacing = \"en12464\"`"),
    ("on = \"room.z_min\"", "on = \"room.z_min\"\nspacing = 0",
        "22:11: `spacing` in [sensors.desk.grid] must be a number of metres above 0 and at most \
         1e9, found 0\n  help: write it like `spacing = \"en12464\"`"),
    ("\"path\"", "\"pth\"",
        "23:13: `estimator` in [render] cannot be `pth`\n  help: did you mean `path`?"),
    ("\"path\"", "\"radiosity\"",
        "23:13: `estimator` in [render] cannot be `radiosity`\n  help: the words here are \
         `double-local`, `double-local-a`, `double-local-b` and `path`"),
    ("\"path\"", "5",
        "23:13: `estimator` in [render] must be a string, found the number 5\n  help: write it \
         like `estimator = \"path\"`"),
    ("estimator = \"path\"", "seed = -1",
        "23:8: `seed` in [render] must be a whole number, 0 or more, found -1\n  help: write it \
         like `seed = 1`"),
    ("\"10m\"", "\"10 minutes\"",
        "24:40: `time` in [render.stop] must be a time above 0 such as \"10m\", \"90s\", \"1h\" \
         or a number of seconds, found \"10 minutes\"\n  help: write it like `time = \"10m\"`"),
    ("\"10m\"", "true",
        "24:40: `time` in [render.stop] must be a time above 0 such as \"10m\", \"90s\", \"1h\" \
         or a number of seconds, found the word true\n  help: write it like `time = \"10m\"`"),
    ("relative_error = 0.01", "relative_error = 1",
        "24:27: `relative_error` in [render.stop] must be between 0 and 1, found 1\n  help: write \
         0.01 for one per cent"),
    ("{ relative_error = 0.01, time = \"10m\" }", "\"10m\"",
        "24:8: `stop` in [render] must be a table such as { relative_error = 0.01, time = \"10m\" \
         }, found the string \"10m\"\n  help: write it like `stop = { relative_error = 0.01, time \
         = \"10m\" }`"),
    ("{ relative_error = 0.01, time = \"10m\" }", "[0.01, \"10m\", 5]",
        "24:8: `stop` in [render] must be a table such as { relative_error = 0.01, time = \"10m\" \
         }, found an array\n  help: write it like `stop = { relative_error = 0.01, time = \"10m\" \
         }`"),
    ("[render]", "[render]\ndetail = 0.25",
        "23:10: `detail` in [render] must be a table such as { pixels = 0.25 }, found the number \
         0.25\n  help: write it like `detail = { pixels = 0.25 }`"),
    ("[render]", "[render]\ndetail = { pixels = -1 }",
        "23:21: `pixels` in [render.detail] must be 0 or more, found -1\n  help: write it like \
         `pixels = 0.25`"),
    ("[render]", "[render]\ndetail = { normal = 200 }",
        "23:21: `normal` in [render.detail] must be from 0 to 180 degrees, found 200\n  help: \
         write it like `normal = 2`"),
    ("[render]", "[render]\ndetail = { pixel = 1 }",
        "23:12: unknown key `pixel` in [render.detail]\n  help: did you mean `pixels`?"),
];

/// Keys and things that do not fit each other.
#[rustfmt::skip]
pub(super) const BAD_RELATIONS: &[Damage] = &[
    ("material = \"walls\"", "material = \"wals\"",
        "10:12: unknown material `wals`\n  help: did you mean `walls`?"),
    ("material = \"walls\"", "material = \"concrete\"",
        "10:12: unknown material `concrete`\n  help: the materials are `floor` and `walls`"),
    ("z_min = \"floor\"", "z_min = \"flor\"",
        "11:19: unknown material `flor`\n  help: did you mean `floor`?"),
    ("[objects.room", "[materials.mixed.mixture]\nof = { walls = 0.5, flor = 0.5 }\n[objects.room",
        "7:28: unknown material `flor`\n  help: did you mean `floor`?"),
    ("[objects.room", "[materials.mixed.mixture]\nof = { walls = 0.5, floor = 0.4 }\n[objects.room",
        "7:6: the shares of a mixture must add up to 1, found 0.9\n  help: write them like `of = \
         { silver = 0.85, dust = 0.15 }`; a part that reflects nothing is a lambert of \
         reflectance 0"),
    ("[objects.room", "[materials.mixed.mixture]\nof = { walls = 1 }\n[objects.room",
        "7:6: a mixture needs two materials or more, found only `walls`\n  help: add what it is \
         mixed with, or write `material = \"walls\"` where `mixed` stands"),
    ("[objects.room", "[materials.mixed.mixture]\nof = { w = 1 }\n[objects.room",
        "7:12: unknown material `w`\n  help: the materials are `floor`, `mixed` and `walls`"),
    ("[objects.room", "[materials.mixed.mixture]\nof = \"walls\"\n[objects.room",
        "7:6: `of` in [materials.mixed.mixture] must be a table, found the string \
         \"walls\"\n  help: write it like `of = { silver = 0.85, dust = 0.15 }`"),
    ("[objects.room", "[materials.mixed.mixture]\nof = { mixed = 0.5, walls = 0.5 }\n[objects.room",
        "7:16: `mixed` is mixed of itself\n  help: name the materials it is mixed of, each with \
         its share of the whole"),
    ("[objects.room", "[materials.mixed.mixture]\nof = {}\n[objects.room",
        "7:6: a mixture needs two materials or more, found none\n  help: write them like `of = { \
         silver = 0.85, dust = 0.15 }`"),
    ("[objects.room", "[materials.mixed.mixture]\nof = { walls = 1.5, floor = -0.5 }\n\
                       [objects.room",
        "7:29: `floor` in [materials.mixed.mixture.of] must be above 0 and at most 1, found \
         -0.5\n  help: it is a share of the area: write 0.25 for a quarter"),
    ("[objects.room", "[materials.a.mixture]\nof = { walls = 0.5, b = 0.5 }\n\
                       [materials.b.mixture]\nof = { walls = 0.5, floor = 0.5 }\n[objects.room",
        "7:25: `b` is a mixture itself\n  help: name the materials it is mixed of, each with its \
         share of the whole"),
    ("estimator = \"path\"", "camera = \"mian\"",
        "23:10: unknown camera `mian`\n  help: did you mean `main`?"),
    ("min = [0, 0, 0]", "min = [4, 0, 0]",
        "8:7: `max` [4.0, 5.0, 3.0] must be above `min` [4.0, 0.0, 0.0] in every \
         coordinate\n  help: swap the coordinates, or write a rectangle for a flat box"),
    ("intensity = 100\n", "",
        "12:1: missing key `intensity` or `flux` in [lights.lamp.point]\n  help: add `intensity = \
         100` (cd) or `flux = 1000` (lm)"),
    ("intensity = 100", "flux = 100\nintensity = 1",
        "14:8: both `intensity` and `flux` in [lights.lamp.point]\n  help: keep one of them"),
    ("lamp.point]", "lamp.spot]\ndirection = [0, 0, -1]\ninner = 30\nouter = 20",
        "15:9: the cone of [lights.lamp.spot] is empty or inside out: `inner` is 30, `outer` is \
         20 degrees\n  help: write half angles from the axis, `inner` at most `outer`, `outer` \
         above 0"),
    ("lamp.point]", "lamp.lambert]",
        "12:1: missing key `direction` in [lights.lamp.lambert]\n  help: add `direction = [0, 0, \
         -1]`"),
    ("to = [2, 3, 1]", "to = [2, 0.5, 1.5]",
        "17:6: `to` and `from` in [cameras.main.perspective] are the same point\n  help: write in \
         `to` a point to look at"),
    ("to = [2, 3, 1]", "up = [0, 2.5, -0.5]\nto = [2, 3, 1]",
        "17:6: `up` in [cameras.main.perspective] is along the view\n  help: write another \
         direction, or leave `up` out"),
    ("room.z_min", "rom.z_min",
        "21:6: unknown object `rom`\n  help: did you mean `room`?"),
    ("room.z_min", "room",
        "21:6: `room` is a box: a face is missing\n  help: write `on = \"room.z_min\"`"),
    ("room.z_min", "room.z_mim",
        "21:6: `room` has no face `z_mim`\n  help: did you mean `z_min`?"),
    ("on = \"room.z_min\"\n", "",
        "20:1: missing key `on` or `height` in [sensors.desk.grid]\n  help: add `on = \
         \"room.z_min\"` or `height = 0.75`"),
    ("on = \"room.z_min\"", "height = 1\non = \"room.z_min\"",
        "21:10: both `on` and `height` in [sensors.desk.grid]\n  help: keep one of them"),
    ("on = \"room.z_min\"", "on = \"room.z_min\"\ncount = [3, 3]\nspacing = 0.5",
        "22:9: both `spacing` and `count` in [sensors.desk.grid]\n  help: keep one of them"),
    ("desk.grid]\non = \"room.z_min\"", "desk.line]\nfrom = [1, 1, 0]\nto = [1, 1, 0]\nnormal = \
                                         [0, 0, 1]\ncount = 3",
        "22:6: `from` and `to` in [sensors.desk.line] are the same point\n  help: move one of \
         them"),
    ("desk.grid]\non = \"room.z_min\"", "desk.line]\nfrom = [1, 1, 0]\nto = [2, 1, 0]\nnormal = \
                                         [0, 0, 1]",
        "20:1: missing key `spacing` or `count` in [sensors.desk.line]\n  help: add `spacing = \
         0.5` (m) or `count = 20`"),
    ("desk.grid]\non = \"room.z_min\"", "desk.line]\nfrom = [1, 1, 0]\nto = [2, 1, 0]\nnormal = \
                                         [0, 0, 1]\ncount = 1",
        "24:9: `count` in [sensors.desk.line] must be a whole number from 2 to 4294967295, found \
         1\n  help: write it like `count = 20`"),
    ("desk.grid]\non = \"room.z_min\"", "desk.surface]\non = \"room\"",
        "20:1: missing key `points` or `vertices` in [sensors.desk.surface]\n  help: add `points \
         = 1000`, or `vertices = true` for a mesh"),
    ("desk.grid]\non = \"room.z_min\"", "desk.surface]\non = \"rom\"\npoints = 9",
        "21:6: unknown object `rom`\n  help: did you mean `room`?"),
    ("desk.grid]\non = \"room.z_min\"", "desk.surface]\non = \"room.z_mim\"\npoints = 9",
        "21:6: `room` has no face `z_mim`\n  help: did you mean `z_min`?"),
    ("desk.grid]\non = \"room.z_min\"", "desk.surface]\non = \"room\"\npoints = 0",
        "22:10: `points` in [sensors.desk.surface] must be a whole number from 1 to 1000000, \
         found 0\n  help: write it like `points = 1000`"),
    ("desk.grid]\non = \"room.z_min\"", "desk.surface]\non = \"room\"\npoints = 2e6",
        "22:10: `points` in [sensors.desk.surface] must be a whole number from 1 to 1000000, \
         found 2000000\n  help: write it like `points = 1000`"),
    ("desk.grid]\non = \"room.z_min\"", "desk.surface]\non = \"room\"\nvertices = true",
        "22:12: `room` is of type `box`, which has no vertices to measure at\n  help: write \
         `points = 1000` instead"),
    ("desk.grid]\non = \"room.z_min\"", "desk.surface]\non = \"room\"\nmeasure = \
                                         \"semicylindrical\"\npoints = 9",
        "22:11: half a cylinder faces one way, and a surface looks to many\n  help: write `plane` \
         or `cylindrical`, or measure at points"),
    ("[render]", "[require]\ndesc = { mean_min = 1 }\n[render]",
        "23:8: unknown group of sensors `desc`\n  help: did you mean `desk`?"),
    ("[render]", "[require]\ndesk = {}\n[render]",
        "23:8: `desk` in [require] requires nothing\n  help: write it like `desk = { mean_min = \
         500 }`"),
    ("[render]", "[require]\ndesk = { uniformity_min = 2 }\n[render]",
        "23:27: `uniformity_min` in [require.desk] must be from 0 to 1, found 2"),
    ("[render]", "[compare]\ndesk = \"sobolew\"\n[render]",
        "23:8: `desk` in [compare] must be \"sobolev\", \"discs\", \"sphere\", \"cap\", \
         \"concentric\", \"cube\", \"furnace\", \"direct\" or a list of illuminances, found \
         \"sobolew\""),
    ("on = \"room.z_min\"", "on = \"room.z_min\"\nborder = 2",
        "22:10: a border of 2 m leaves nothing of a surface 4 m wide\n  help: write less than 2"),
];

/// The rarer shapes.
#[rustfmt::skip]
pub(super) const BAD_SHAPES: &[Damage] = &[
    ("top.grid]\non = \"table\"\ncount = [3, 2]", "top.surface]\non = \"ground\"\npoints = 9",
        "37:6: `ground` is an infinite plane, which cannot be covered\n  help: write a rectangle \
         instead of the plane, or lay a grid of sensors at a `height`"),
    ("top.grid]\non = \"table\"\ncount = [3, 2]", "top.surface]\non = \"lid.top\"\npoints = 9",
        "37:6: `lid` is of type `disc` and has no part `top`\n  help: write `on = \"lid\"`"),
    ("top.grid]\non = \"table\"\ncount = [3, 2]", "top.surface]\non = \"twin\"\npoints = \
                                                   9\nvertices = true",
        "38:10: `points` in [sensors.top.surface] has no meaning: a mesh has the vertices it \
         has\n  help: leave it out, or leave out `vertices`"),
    ("top.grid]\non = \"table\"\ncount = [3, 2]", "top.surface]\non = \"ball\"\nvertices = true",
        "36:1: missing key `points` in [sensors.top.surface]\n  help: add `points = 1000`: the \
         vertices are those of a geodesic sphere with so many at least"),
    ("edge_v = [0, 1, 0]", "edge_v = [1, 1, 0]",
        "6:10: `edge_v` must be perpendicular to `edge_u`, found 45.000 degrees\n  help: write a \
         mesh for a parallelogram"),
    ("edge_v = [0, 1, 0]", "edge_v = [0, 0, 0]",
        "6:10: `edge_v` in [objects.table.rectangle] has length 0\n  help: write the vector along \
         the edge, metres"),
    ("radius = 1\n", "radius = -1\n",
        "11:10: `radius` in [objects.lid.disc] must be above 0 and at most 1e9 metres, found \
         -1\n  help: write it like `radius = 0.5`"),
    ("normal = [0, 0, 2]", "normal = [0, 0, 0]",
        "10:10: `normal` in [objects.lid.disc] must be a direction, found a vector of length \
         0\n  help: write it like `normal = [0, 0, 1]`"),
    ("file = \"head.obj\"", "file = \"\"",
        "23:8: `file` in [objects.twin.mesh] must name a file, found an empty string\n  help: \
         write it like `file = \"../head.obj\"`"),
    ("up = \"y\"", "up = \"w\"",
        "25:6: `up` in [objects.twin.mesh] cannot be `w`\n  help: the words here are `x`, `y` and \
         `z`"),
    ("unit = \"mm\"", "unit = \"ft\"",
        "26:8: `unit` in [objects.twin.mesh] cannot be `ft`\n  help: the words here are \
         `km`, `m`, `cm`, `mm`, `um` and `in`"),
    ("smooth = true", "smooth = true\ndegree = 4",
        "25:1: unknown key `degree` in [objects.twin.mesh]\n  help: the keys here are `file`, \
         `at`, `scale`, `rotate`, `unit`, `up`, `smooth` and `material`"),
    ("smooth = true", "scale = 0",
        "24:9: `scale` in [objects.twin.mesh] must be above 0, found 0\n  help: write it like \
         `scale = 6`"),
    ("degree = 8.0", "degree = 8.5",
        "30:10: `degree` in [objects.\"the head\".sh] must be a whole number from 0 to 1400, \
         found 8.5\n  help: write it like `degree = 32`"),
    ("degree = 8.0\n", "",
        "28:1: missing key `degree` in [objects.\"the head\".sh]\n  help: add `degree = 32`"),
    ("\"step-bisection\"", "\"certified\"",
        "33:8: `step` means nothing to this intersector, which steps by its own bounds\n  help: \
         add `intersector = \"step-bisection\"`, or leave `step` out"),
    ("step = 0.01", "step = 1e-12",
        "33:8: `step` of 1e-12 takes 2e12 steps a ray\n  help: the shortest step is 1e-5 largest \
         radii"),
    ("\"step-bisection\"", "\"march\"",
        "32:15: `intersector` in [objects.\"the head\".sh] cannot be `march`\n  help: the words \
         here are `patches`, `certified` and `step-bisection`"),
    ("{ axis = [0, 0, 5], degrees = 90 }", "{ axis = [0, 0, 5] }",
        "34:10: missing key `degrees` in [objects.\"the head\".sh.rotate]\n  help: add `degrees = \
         25`"),
    ("{ axis = [0, 0, 5], degrees = 90 }", "90",
        "34:10: `rotate` in [objects.\"the head\".sh] must be a table such as { axis = [0, 0, 1], \
         degrees = 25 }, found the number 90\n  help: write it like `rotate = { axis = [0, 0, 1], \
         degrees = 25 }`"),
    ("on = \"table\"", "on = \"ball\"",
        "37:6: a grid cannot lie on `ball`, which is of type `sphere`\n  help: name a face of a \
         box or a rectangle, or write `height` instead of `on`"),
    ("on = \"table\"", "on = \"table.z_min\"",
        "37:6: `table` is a rectangle, which has no faces to name\n  help: write `on = \"table\"`"),
    ("walks = 1e6", "walks = 0",
        "57:18: `walks` in [illum.stop] must be a whole number, 1 or more, found 0\n  help: write \
         it like `walks = 100000`"),
    ("degree = 8.0", "degree = 8.0\ndetail = { normal = [0, 0, 1] }",
        "31:21: `normal` in [objects.\"the head\".sh.detail] must be a number, found an \
         array\n  help: write it like `normal = 2`"),
];

/// Overrides: key path, value, message.
#[rustfmt::skip]
pub(super) const BAD_OVERRIDES: &[Damage] = &[
    ("lights.lamp.point.intensty", "250",
        "-D lights.lamp.point.intensty: unknown key `intensty` in [lights.lamp.point]\n  help: \
         did you mean `intensity`?"),
    ("lights.lamp.point.intensity", "2O0",
        "-D lights.lamp.point.intensity: `intensity` in [lights.lamp.point] must be a number, \
         found the string 2O0\n  help: write it like `intensity = 100`"),
    ("lights.lamp.point.intensity", "-3",
        "-D lights.lamp.point.intensity: `intensity` in [lights.lamp.point] must be above 0, \
         found -3\n  help: write it like `intensity = 100`"),
    ("lights.lamp.point.flux", "3",
        "-D lights.lamp.point.flux: both `intensity` and `flux` in [lights.lamp.point]\n  help: \
         keep one of them"),
    ("lights.lmap.point.intensity", "3",
        "-D lights.lmap.point.intensity: there is no `lmap` in [lights]\n  help: did you mean \
         `lamp`?"),
    ("light.lamp.point.intensity", "3",
        "-D light.lamp.point.intensity: unknown key `light`\n  help: did you mean `lights`?"),
    ("lights.lamp.pont.intensity", "3",
        "-D lights.lamp.pont.intensity: unknown type `pont` in [lights.lamp]\n  help: did you \
         mean `point`?"),
    ("lights.lamp", "3",
        "-D lights.lamp: [lights.lamp] must be a table with a type in its header\n  help: write \
         [lights.lamp.point]; the types of lights are: `point`, `lambert` and `spot`"),
    ("lights.lamp.point", "[[0, 0, 0], 1]",
        "-D lights.lamp.point: `point` in [lights.lamp] must be a table\n  help: write \
         [lights.lamp.point]; the types of lights are: `point`, `lambert` and `spot`"),
    ("lights.spare.point", "{ at = [0, 0, 1] }",
        "-D lights.spare.point: missing key `intensity` or `flux` in \
         [lights.spare.point]\n  help: add `intensity = 100` (cd) or `flux = 1000` (lm)"),
    ("lights.lamp.point.at.x", "3",
        "-D lights.lamp.point.at.x: `at` is of type array, not a table\n  help: give its value \
         whole"),
    ("lights.lamp.point.at", "[1, 2",
        "-D lights.lamp.point.at=[1, 2: the value is not valid TOML: unclosed array, expected \
         `]`\n  help: write KEY=VALUE, as in lights.lamp.point.intensity=250; quote names that \
         hold dots or spaces"),
    ("lights.lamp.point.at", "[1, 2, a]",
        "-D lights.lamp.point.at=[1, 2, a]: the value is not valid TOML: string values must be \
         quoted, expected literal string\n  help: write KEY=VALUE, as in \
         lights.lamp.point.intensity=250; quote names that hold dots or spaces"),
    ("lights.lamp.point.at", "[1, 2]",
        "-D lights.lamp.point.at: `at` in [lights.lamp.point] must be an array of 3 numbers, \
         found 2 of them\n  help: write it like `at = [1, 1, 1]`"),
    ("lights.lamp.point.at", "[1, 2, \"3\"]",
        "-D lights.lamp.point.at: `at` in [lights.lamp.point] must be a number, found the string \
         \"3\"\n  help: write it without quotes"),
    ("lights.lamp.point.at", "",
        "-D lights.lamp.point.at=: the value is missing\n  help: write KEY=VALUE, as in \
         lights.lamp.point.intensity=250; quote names that hold dots or spaces"),
    ("lights..point", "3",
        "-D lights..point: the key is not a path of names with dots between them\n  help: write \
         KEY=VALUE, as in lights.lamp.point.intensity=250; quote names that hold dots or spaces"),
    ("", "3",
        "-D : the key is not a path of names with dots between them\n  help: write KEY=VALUE, as \
         in lights.lamp.point.intensity=250; quote names that hold dots or spaces"),
    ("a = 1 #", "3",
        "-D a = 1 #: the key is not a path of names with dots between them\n  help: write \
         KEY=VALUE, as in lights.lamp.point.intensity=250; quote names that hold dots or spaces"),
    ("objects.room.sphere.radius", "3",
        "-D objects.room.sphere.radius: [objects.room] has more than one type: `box` and \
         `sphere`\n  help: a thing has one type; give the other one a name of its own"),
    ("objects.room.box.material", "wals",
        "-D objects.room.box.material: unknown material `wals`\n  help: did you mean `walls`?"),
    ("objects.room.box.faces.z_mx", "floor",
        "-D objects.room.box.faces.z_mx: unknown key `z_mx` in [objects.room.box.faces]\n  help: \
         did you mean `z_max`?"),
    ("cameras.main.perspective.to", "[2, 0.5, 1.5]",
        "-D cameras.main.perspective.to: `to` and `from` in [cameras.main.perspective] are the \
         same point\n  help: write in `to` a point to look at"),
    ("format", "2",
        "-D format: format 2 is not known\n  help: this version reads format 1; write `format = \
         1`, or use the version the scene was made for"),
    ("render.estimator", "double-locl",
        "-D render.estimator: `estimator` in [render] cannot be `double-locl`\n  help: did you \
         mean `double-local`?"),
    ("render.stop.tme", "3",
        "-D render.stop.tme: unknown key `tme` in [render.stop]\n  help: did you mean `time`?"),
];
