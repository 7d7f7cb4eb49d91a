"""A small scene of a plate that remembers: 320 steps in two pieces per pass, 3 ms of a second."""

MEMORY = """\
name: memory
sphere: {radius_mm: 1, density_kg_m3: 7850}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, hardness_gpa: 2.1, plasticity: permanent,
  density_kg_m3: 7850}
surface: {kind: gaussian, roughness_ra_um: 0.1, correlation_length_um: 10, spacing_um: 2,
  width_um: 128, seed: 3}
rolling: {load_n: 0.5, speed_m_s: 0.05, distance_mm: 0.64, passes: 2}
numerics: {edges: sharp}
"""
