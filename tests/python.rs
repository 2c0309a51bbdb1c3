//! The wheel's own tests, where a Python has it installed: `pip install ./python pytest`. Else they are skipped, and say so.

use std::path::Path;
use std::process::Command;

#[test]
fn the_wheel_passes_its_tests() {
    let python = std::env::var("PYTHON").unwrap_or_else(|_| "python3".into());
    let has_it = Command::new(&python).args(["-c", "import pmcip, pytest"]).output();
    if !has_it.is_ok_and(|output| output.status.success()) {
        eprintln!("skipped: there is no {python} with pmcip and pytest");
        return;
    }
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("python/tests");
    let output = Command::new(&python).args(["-m", "pytest", "-q"]).arg(tests).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
}
