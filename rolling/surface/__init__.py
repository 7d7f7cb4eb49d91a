"""Surface heights as arrays in SI: made, prepared, levelled, and described in numbers.

height_law
    laws of random heights as numbers: autocorrelation or self-affine spectrum, size, moments
heights, made
    make random heights of a law, with a skewness and a kurtosis from Johnson's system, and compute
    roughness statistics
wave_law, stylus
    laws of random waves around a circle; what a stylus reads of roughness across its lay
single_faults, ball_form
    add pits, scratches and other faults; waves around a ball, and ball and plate together
lowered_waves
    lowers waves along the track by third octaves, with the phases that they have
levelling, form, chosen_form
    finds tilt and seam of heights, and removes the tilt; forms of least squares; the form that a
    measurement is described without
markers
    finds values that mark unmeasured points
period_grid, gaussian_filter, preparation
    the nodes of a period; Gaussian filters of ISO 16610; fill, filter, resample and close measured
    heights by ISO 25178-3
step_words
    names of forms and filters, as standards have them
instrument
    finds what the instrument of a measurement could not see
parameters, lay, character
    compute the areal parameters of ISO 25178-2, the lay, and the numbers by which finishes compare
profile_parameters
    evaluate profiles along the track by the names of ISO 21920-2
contact_average
    the spectrum of the heights that a contact averages along its track
alike_places
    how much alike the levels of tracks on one surface are
refined, subcell_contact
    compute heights between the nodes, on other grids and on sub-cells, and the contact on them
"""
