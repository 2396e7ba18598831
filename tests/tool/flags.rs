//! No verb ignores a flag: for every kind of input, each flag of its help changes what is said or
//! written, or is refused.

use std::collections::BTreeMap;

use rayon::prelude::*;

use crate::common::desk::Desk;
use crate::golden::transcript;

/// Commands to which flags are added, one for each kind of input that a verb tells apart.
const COMMANDS: [&str; 30] = [
    "render room.toml --quick -o x.exr",
    "illum room.toml --quick",
    "falsecolor view.exr -o x.svg",
    "falsecolor lux.csv -o x.svg",
    "check torn.obj",
    "fit stone.obj -l 3 -o x.txt",
    "fit stone.obj -l 3 -o x.hxc",
    "fit points.xyz -l 1 -o x.txt",
    "fit stone.obj other.ply -l 2 -o d",
    "info stone.obj",
    "info rock.txt",
    "info small.hxc",
    "info points.xyz",
    "info cells.csv",
    "info skull.coef",
    "convert rock.txt x.npy",
    "convert stone.obj x.ply",
    "convert small.hxc x.txt",
    "convert rock.txt x.hxc",
    "sweep stone.obj -l 2,3 -o d",
    "spectrum rock.txt",
    "diff small.hxc stone.obj",
    "mesh small.hxc -o x.obj",
    "transform small.hxc -o x.txt",
    "mean small.hxc small.hxc -o x.txt",
    "modes rock.txt small.hxc",
    "modes table.csv",
    "random --power-law rms=0.1,exponent=2 -l 2 -o x.txt",
    "random --gaussian-sphere sigma=0.1,exponent=2 -l 2 -o x.txt",
    "random --spectrum rock.txt -o x.txt",
];

/// What makes the inputs that the repository does not have.
const BEFORE: &str = "fit stone.obj -l 3 -o small.hxc; \
    fit stone.obj other.ply -l 2 -o fits --table table.csv; \
    render room.toml --quick --size 8x6 -o view.exr; illum room.toml --quick -o lux.csv";

/// A value of each flag that has one, another than its default.
const VALUES: [(&str, &str); 59] = [
    ("-D", "materials.clay.lambert.reflectance=0.31"),
    ("--add-radius", "2"),
    ("--align-to", "rock.txt"),
    ("--angle", "30"),
    ("--at", "1"),
    ("--axis", "0,0,1"),
    ("--bad", "bad.ply"),
    ("--camera", "other"),
    ("--centre", "0.1,0,0"),
    ("--channel", "stderr.Y"),
    ("--checkpoint", "c.checkpoint"),
    ("--count", "2"),
    ("--crop", "0,0,4,4"),
    ("--csphase", "-1"),
    ("--degree", "1"),
    ("--divisions", "3"),
    ("--estimator", "path"),
    ("--euler", "10,20,30"),
    ("--exposure", "0.3"),
    ("--fill-holes", "5"),
    ("--filter", "lanczos"),
    ("--from", "dov"),
    ("--gaussian-sphere", "sigma=0.2"),
    ("--group", "other"),
    ("--label", "W"),
    ("--lambda", "0.01"),
    ("--lat-long", "5x6"),
    ("--layers", "none"),
    ("--log", "3"),
    ("--map", "map.ply"),
    ("--matrix", "0,-1,0,1,0,0,0,0,1"),
    ("--min", "0.5"),
    ("--mirror", "x"),
    ("--modes", "1"),
    ("--normalisation", "ortho"),
    ("--not-star", "first"),
    ("--not-star-limit", "1"),
    ("--oversampling", "7"),
    ("--palette", "magma"),
    ("--power-law", "rms=0.2,exponent=3"),
    ("--projection", "grid"),
    ("--quaternion", "0,0,1,1"),
    ("--radius", "3"),
    ("--recentre", "centroid"),
    ("--resolution", "2"),
    ("--row", "2"),
    ("--scale", "2"),
    ("--seed", "7"),
    ("--size", "9x7"),
    ("--spectrum", "rock.txt"),
    ("--table", "new.csv"),
    ("--table-layout", "aics"),
    ("--to", "dov"),
    ("--to-csphase", "-1"),
    ("--to-normalisation", "ortho"),
    ("--tolerance", "0.01"),
    ("--unit", "km"),
    ("--up", "x"),
    ("--weld", "0.001"),
];
