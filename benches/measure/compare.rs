//! Speed against error as a Markdown table: `cargo run --release -p measure -- compare SCENE …`, with the arguments of
//! `pmcip compare`. Ratios are uniform ÷ method: above 1 is better.

use serde_json::Value;
use std::process::Command;

/// Prints the table.
pub fn run(arguments: &[String]) {
    let folder = tempfile::tempdir().expect("a folder for the report");
    let cargo = std::env::var("CARGO").unwrap_or("cargo".into());
    let mut command = Command::new(cargo);
    command.args(["run", "--release", "--quiet", "--package", "pmcip", "--", "compare"]).args(arguments);
    command.args(["--quiet", "-o"]).arg(folder.path());
    let output = command.current_dir(crate::root()).output().expect("cargo runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let report = std::fs::read(folder.path().join("report.json")).expect("a report");
    let report: Value = serde_json::from_slice(&report).expect("a report is JSON");
    let rows = report["rows"].as_array().expect("rows");
    // Only frames flicker.
    let flickers = rows.iter().any(|row| row["flicker"].is_number());
    let (title, rule) = if flickers { (" flicker ÷ |", " --- |") } else { ("", "") };
    println!("| method | spp | s | Err | Err ÷ | low-pass Err ÷ | P-Eff, ÷ uniform | energy |{title}");
    println!("| --- | --- | --- | --- | --- | --- | --- | --- |{rule}");
    for row in rows {
        let number = |name: &str| row[name].as_f64().unwrap_or(f64::NAN);
        let uniform = rows.iter().find(|other| other["method"] == "uniform" && other["spp"] == row["spp"]);
        let ratio = |name: &str| uniform.and_then(|u| u[name].as_f64()).unwrap_or(f64::NAN) / number(name);
        let flicker = if flickers { format!(" {:.2} |", ratio("flicker")) } else { String::new() };
        println!(
            "| {} | {} | {:.2} | {:.3} | {:.2} | {:.2} | {:.2} | {:+.2} % ± {:.2} |{flicker}",
            row["method"].as_str().expect("a method"),
            number("spp"),
            number("seconds"),
            number("err"),
            ratio("err"),
            ratio("err_lowpass"),
            1.0 / ratio("p_eff"),
            100.0 * number("energy_bias"),
            100.0 * number("energy_bias_stderr"),
        );
    }
    if let Some(ratio) = report["oracle_ratio"].as_f64() {
        let rays = report["oracle_ratio_equal_rays"].as_f64();
        println!(
            "\nOracle ratio {ratio:.2}{}.",
            rays.map_or(String::new(), |r| format!(", at equal rays {r:.2}"))
        );
    }
}
