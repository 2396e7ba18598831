//! What a user meets first: the page of `harmolux` alone, and the verbs of `--help` in groups.

#[cfg(test)]
mod tests;

use std::fmt::Write;

use clap::Command;

/// The page of the tool without any argument.
pub(crate) const TEXT: &str = "\
harmolux: shapes as spherical harmonics, and light in rooms with its error

Three things to try, in a room that `harmolux new room.toml` writes, or with a mesh:
  harmolux render room.toml --preview        a picture
  harmolux illum room.toml                   lux at its sensors, each with an interval
  harmolux fit head.obj -l 32 -o head.txt    a mesh becomes 1089 numbers

`harmolux --help` lists all verbs, `harmolux VERB --help` shows examples of one.";

/// The verbs, in groups.
const GROUPS: [(&str, &[&str]); 3] = [
    (
        "Shapes",
        &[
            "check",
            "fit",
            "info",
            "mesh",
            "diff",
            "spectrum",
            "evaluate",
            "transform",
            "mean",
            "modes",
            "random",
            "sweep",
            "view",
        ],
    ),
    ("Light", &["new", "render", "illum", "probe", "exact", "falsecolor", "compare"]),
    ("Files", &["convert", "completions", "man", "help"]),
];

/// Returns the tool with a help that lists the verbs in groups, which clap has no way to do.
pub(crate) fn grouped(mut tool: Command) -> Command {
    tool.build();
    let mut verbs = String::new();
    for (heading, names) in GROUPS {
        let _ = writeln!(verbs, "\x1b[1m\x1b[4m{heading}:\x1b[0m");
        for verb in names.iter().filter_map(|name| tool.find_subcommand(name)) {
            let about = verb.get_about().map(ToString::to_string).unwrap_or_default();
            let _ = writeln!(verbs, "  \x1b[1m{:<12}\x1b[0m {about}", verb.get_name());
        }
        verbs.push('\n');
    }
    tool.help_template(format!(
        "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{verbs}\
         \x1b[1m\x1b[4mOptions:\x1b[0m\n{{options}}{{after-help}}"
    ))
}
