//! What the library advises, in the flags of the command line.

use harmolux::Error;
use harmolux::error::Advice;

/// Returns the text of an error, its advice in flags.
pub(crate) fn told(error: &Error) -> String {
    error.told(&in_flags)
}

const ANEW: &str = "begin anew with `--force` and without `--resume`";
const CONVENTION: &str = "`--normalisation 4pi|ortho|schmidt|unnorm` and `--csphase 1|-1`";

/// Returns an advice in flags.
pub(crate) fn in_flags(advice: &Advice) -> String {
    match advice {
        Advice::Repair(None) => {
            "`--repair` mends that (`harmolux check --repair -o FILE` writes it)".to_owned()
        }
        Advice::Repair(Some(edges)) => format!(
            "`--repair` joins vertices in one place, `--repair --fill-holes {edges}` fills holes \
             too (`harmolux check --repair -o FILE` writes it)"
        ),
        Advice::Overwrite => "choose another name, or replace it with `--force`".to_owned(),
        Advice::BeginAnew(first) => format!("{}{ANEW}", first.unwrap_or("")),
        Advice::KeepLargestPiece => "keep one piece alone \
            (`harmolux check --repair --largest-piece -o FILE` writes it)"
            .to_owned(),
        Advice::FitEnvelope => "`harmolux fit --not-star outermost` (or first, mean) \
            fits an envelope of a mesh with small folds"
            .to_owned(),
        Advice::SkipCrossings => {
            "drop repeated faces with `--repair`, or leave crossings out with `--skip-crossings`"
                .to_owned()
        }
        Advice::AcceptFolds => {
            "raise `--not-star-limit`, give another centre, or cut the mesh in parts".to_owned()
        }
        Advice::FitSurface => {
            "fit its surface with `harmolux fit`, or make a mesh of it: `harmolux convert` to .ply"
                .to_owned()
        }
        Advice::FitMesh => "make coefficients of it first: `harmolux fit`".to_owned(),
        Advice::AddRadius => {
            "if these are heights, add their reference radius with `--add-radius` (as `harmolux \
             convert` does)"
                .to_owned()
        }
        Advice::StateFormat(names) => format!("say its format with `--from`: {names}"),
        Advice::ReadAsText => "read a table without header with `--from text`".to_owned(),
        Advice::StateConvention => {
            format!("say it with {CONVENTION} (pyshtools writes 4pi and 1 unless told otherwise)")
        }
        Advice::LeaveOutConvention => "leave out `--normalisation` and `--csphase`".to_owned(),
        Advice::CompleteComments { key, example } => format!(
            "add a line as `# {key}: {example}`, or remove all comments and give {CONVENTION}"
        ),
        Advice::LeaveOutUnit => "leave out `--unit`".to_owned(),
        Advice::ChooseRow => "choose one with `--row`, counted from 1".to_owned(),
        Advice::LeaveOutRow => "leave out `--row`".to_owned(),
        Advice::Convert { advice, path } => {
            let (advice, path) = (in_flags(advice), path.display());
            format!("{advice}, to `harmolux convert {path} NEW.txt`, and name NEW.txt instead")
        }
        // Advice that knows no flag.
        other => other.to_string(),
    }
}
