//! `cargo bench` at the root says where the benches are: in a workspace of their own, so that `cargo test` does not build them.

fn main() {
    println!("The benches run with `cargo benches`; one of them: `cargo benches --bench loop`.");
}
