//! Writes every table of `benches/README.md` that needs no other renderer.
//!
//! `cargo run --release -p measure -- all [NAME…]`: a table stands between `<!-- measure NAME … -->`, which says how it is
//! made, and `<!-- end -->`. With names, only tables by these programs. Needs a machine that does nothing else.

use std::path::Path;
use std::process::Command;
use std::time::Instant;

const START: &str = "<!-- measure ";
const END: &str = "<!-- end -->";

/// Makes the tables again.
pub fn run(names: &[String]) {
    let file = crate::root().join("benches/README.md");
    let text = std::fs::read_to_string(&file).expect("benches/README.md");
    for command in commands(&text) {
        let wanted = |name: &String| command.split(' ').next() == Some(name);
        if names.is_empty() || names.iter().any(wanted) {
            let start = Instant::now();
            let table = table(&command);
            eprintln!("{command}: {:.0} s", start.elapsed().as_secs_f64());
            write(&file, &command, &table);
        }
    }
}

/// What the tables are made by, in their order.
fn commands(text: &str) -> Vec<String> {
    let starts = text.lines().filter_map(|line| line.strip_prefix(START));
    starts.map(|rest| rest.trim_end_matches("-->").trim().to_string()).collect()
}

/// What a command prints.
fn table(command: &str) -> String {
    let program = std::env::current_exe().expect("this program");
    let output = Command::new(program).args(command.split(' ')).current_dir(crate::root()).output();
    let output = output.expect("this program runs");
    assert!(output.status.success(), "{command}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("text")
}

/// Puts a table where its command stands, so that an interrupted run loses nothing.
fn write(file: &Path, command: &str, table: &str) {
    let text = std::fs::read_to_string(file).expect("benches/README.md");
    std::fs::write(file, replaced(&text, command, table)).expect("benches/README.md is written");
}

fn replaced(text: &str, command: &str, table: &str) -> String {
    let start = format!("{START}{command} -->\n");
    let (before, after) = text.split_once(&start).expect("the command stands in the file");
    let (_, after) = after.split_once(END).expect("the table has an end");
    format!("{before}{start}\n{}\n\n{END}{after}", table.trim())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_takes_the_place_of_the_old_one() {
        let text = "a\n<!-- measure rays x -->\nold\n<!-- end -->\nb\n<!-- measure bias -->\n<!-- end -->\n";
        assert_eq!(commands(text), ["rays x", "bias"]);
        let once = replaced(text, "rays x", "new\n");
        assert_eq!(once, text.replace("old", "\nnew\n"));
        assert_eq!(replaced(&once, "rays x", "new"), once);
    }
}
