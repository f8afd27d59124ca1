//! The paper, item by item: what it shows, and whether what it says holds.
//!
//! Barham & Burby, "Diagnosing symplecticity in simulations of high-dimensional Hamiltonian
//! systems". Each item writes its figures and data into the run folder and judges
//! the paper's claims from the numbers it measured. [`ITEMS`] lists them, [`reproduce`] runs them.

mod accumulation;
mod appendix_a;
mod appendix_b;
mod broken_loops;
mod census;
mod claim;
mod closed_forms;
mod convergence;
mod drift;
mod error;
mod estimate;
mod families;
mod fig1;
mod fig2;
mod fig3;
mod fig4;
mod fig5;
mod fig6;
mod fig6_claims;
mod fig7;
mod fig7_claims;
mod fig8;
mod fig9;
mod fig9_claims;
mod formulas;
mod interpolated;
mod item;
mod near_symplectic;
mod particle_scaling;
mod physics;
mod pic;
mod pic_panels;
mod reproduce;
mod settings;
mod sweep;
mod true_defect;
mod uncertainty;

pub use claim::{Claim, Judgement, Origin, claims_markdown, claims_summary};
pub use error::PaperError;
pub use item::{Item, SettingsCheck};
pub use reproduce::{Progress, reproduce};
pub use settings::{Key, Kind, SettingError, Settings, Value};

/// Every item.
pub const ITEMS: &[Item] = &[
    fig1::ITEM,
    fig2::ITEM,
    convergence::ITEM,
    near_symplectic::ITEM,
    closed_forms::ITEM,
    fig3::ITEM,
    fig4::ITEM,
    fig5::ITEM,
    fig6::ITEM,
    fig7::ITEM,
    fig8::ITEM,
    fig9::ITEM,
    families::ITEM,
    broken_loops::ITEM,
    physics::ITEM,
    formulas::ITEM,
    appendix_a::ITEM,
    appendix_b::ITEM,
    census::ITEM,
];
