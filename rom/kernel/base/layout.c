/* Messages of the status codes, and the layout of the public structures in memory. */
#include "slipmode.h"

/* Rows of STRUCTURE, a name that each block below defines: the whole, and one field. */
#define NAME_OF(structure) #structure
#define NAME(structure) NAME_OF(structure)
#define WHOLE {NAME(STRUCTURE), "", 0, sizeof(STRUCTURE)}
#define FIELD(field) \
    {NAME(STRUCTURE), #field, offsetof(STRUCTURE, field), sizeof(((STRUCTURE *)0)->field)}

static const sm_layout_row ROWS[] = {
#define STRUCTURE sm_contact
    WHOLE, FIELD(contacts), FIELD(modes), FIELD(law), FIELD(alpha), FIELD(limit), FIELD(stiffness),
    FIELD(damping), FIELD(coupling), FIELD(mass), FIELD(response), FIELD(elastic),
#undef STRUCTURE
#define STRUCTURE sm_elastic
    WHOLE, FIELD(elements), FIELD(sliders), FIELD(element), FIELD(slider), FIELD(reference),
#undef STRUCTURE
#define STRUCTURE sm_element
    WHOLE, FIELD(law), FIELD(column), FIELD(first_slider), FIELD(sliders), FIELD(tangents),
    FIELD(friction), FIELD(preload), FIELD(tangential_stiffness), FIELD(normal_stiffness),
    FIELD(gap),
#undef STRUCTURE
#define STRUCTURE sm_modal_response
    WHOLE, FIELD(orders_count), FIELD(orders), FIELD(asked), FIELD(dynamic_stiffness),
    FIELD(marched), FIELD(drawn), FIELD(advance), FIELD(periodic), FIELD(start), FIELD(held),
#undef STRUCTURE
#define STRUCTURE sm_discretisation
    WHOLE, FIELD(rates), FIELD(steps), FIELD(lines), FIELD(orders_count), FIELD(orders),
    FIELD(tolerance), FIELD(smallest_scale), FIELD(max_periods),
#undef STRUCTURE
#define STRUCTURE sm_torus_points
    WHOLE, FIELD(count), FIELD(amplitudes), FIELD(near),
#undef STRUCTURE
#define STRUCTURE sm_torus_motion
    WHOLE, FIELD(harmonics), FIELD(mean_square), FIELD(residual), FIELD(marched),
#undef STRUCTURE
#define STRUCTURE sm_table
    WHOLE, FIELD(modes), FIELD(combinations), FIELD(power), FIELD(count_a), FIELD(count_b),
    FIELD(node_a), FIELD(node_b), FIELD(values), FIELD(rate_correction), FIELD(detuning),
#undef STRUCTURE
#define STRUCTURE sm_combination
    WHOLE, FIELD(mode), FIELD(n), FIELD(m),
#undef STRUCTURE
#define STRUCTURE sm_slow_flow
    WHOLE, FIELD(paper), FIELD(natural), FIELD(damping), FIELD(table), FIELD(carrier),
    FIELD(coupling_ratio), FIELD(off_resonance), FIELD(cross_response), FIELD(combination),
#undef STRUCTURE
#define STRUCTURE sm_curve
    WHOLE, FIELD(unknowns), FIELD(largest_step), FIELD(rates), FIELD(of),
#undef STRUCTURE
#define STRUCTURE sm_branch
    WHOLE, FIELD(before), FIELD(after), FIELD(closed),
#undef STRUCTURE
#define STRUCTURE sm_forced
    WHOLE, FIELD(flow), FIELD(inputs), FIELD(scale),
#undef STRUCTURE
#define STRUCTURE sm_motion
    WHOLE, FIELD(wanted), FIELD(elastic), FIELD(modes_out), FIELD(forces_out), FIELD(contacts_out),
    FIELD(orders_count), FIELD(orders), FIELD(reaction), FIELD(response), FIELD(steps_per_period),
    FIELD(memory_periods),
#undef STRUCTURE
#define STRUCTURE sm_full
    WHOLE, FIELD(coordinates), FIELD(contacts), FIELD(modes), FIELD(outputs), FIELD(law),
    FIELD(diagonal), FIELD(alpha), FIELD(step), FIELD(limit), FIELD(stiffness), FIELD(damping),
    FIELD(directions), FIELD(patterns), FIELD(output), FIELD(inverse), FIELD(resistance),
    FIELD(elastic), FIELD(own), FIELD(ahead), FIELD(flexibility),
#undef STRUCTURE
#define STRUCTURE sm_full_samples
    WHOLE, FIELD(count), FIELD(every), FIELD(displacement), FIELD(velocity), FIELD(contact),
    FIELD(dissipated),
#undef STRUCTURE
#define STRUCTURE sm_harmonic_sum
    WHOLE, FIELD(modes), FIELD(orders_count), FIELD(orders), FIELD(signals), FIELD(shape),
    FIELD(coefficient),
#undef STRUCTURE
#define STRUCTURE sm_contact_samples
    WHOLE, FIELD(count), FIELD(times), FIELD(displacement), FIELD(velocity), FIELD(force),
#undef STRUCTURE
#define STRUCTURE sm_trajectory_steps
    WHOLE, FIELD(count), FIELD(inputs), FIELD(duration), FIELD(start), FIELD(end),
#undef STRUCTURE
#define STRUCTURE sm_trace
    WHOLE, FIELD(capacity), FIELD(count), FIELD(outputs), FIELD(done), FIELD(elapsed),
#undef STRUCTURE
#define STRUCTURE sm_inputs
    WHOLE, FIELD(force), FIELD(force_rate), FIELD(frequency), FIELD(frequency_rate), FIELD(phase),
    FIELD(phase_rate), FIELD(limit_scale), FIELD(limit_scale_rate), FIELD(angle),
#undef STRUCTURE
#define STRUCTURE sm_segment
    WHOLE, FIELD(start), FIELD(duration), FIELD(amplitude_start), FIELD(amplitude_end),
    FIELD(rate_start), FIELD(rate_end), FIELD(angle), FIELD(frequency), FIELD(frequency_rate),
    FIELD(reaction_start), FIELD(reaction_end),
#undef STRUCTURE
};

const sm_layout_row *sm_layout(size_t *count) {
    *count = sizeof ROWS / sizeof *ROWS;
    return ROWS;
}

const char *sm_message(sm_status status) {
    switch (status) {
    case SM_OK: return "ok";
    case SM_BAD_ARGUMENT: return "an argument has a size, sign or order that is not allowed";
    case SM_NOT_FINITE: return "a value is NaN or infinite";
    case SM_NO_MEMORY: return "out of memory";
    case SM_NOT_CONVERGED: return "the implicit contact step did not converge";
    case SM_OUTSIDE_TABLE: return "an amplitude is outside the friction table";
    case SM_STEP_TOO_SMALL: return "the slow flow cannot meet its tolerance in so long a step";
    }
    return "unknown status";
}
