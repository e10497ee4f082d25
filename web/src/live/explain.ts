// What each technique is about: the idea, its equation, what goes wrong without it, and where it lives.

export interface Explanation {
  title: string;
  idea: string;
  equation?: string;
  without?: string;
  file?: string;
}

/** By group of options; the order is that of the panel. A group that is not here is shown with the engine's own words. */
export const EXPLANATIONS: Record<string, Explanation> = {
  solver: {
    title: 'Sweeps and substeps',
    idea:
      'Contacts and joints are rows of one table. Projected Gauss–Seidel visits row after row, sets its impulse so that the row is satisfied, and clips the sum to its bounds. Substeps shorten the step between two detections: errors shrink with their square, so they often buy more than sweeps.',
    equation: 'λᵢ ← clip(λᵢ − (Jᵢu + biasᵢ) / (JᵢM⁻¹Jᵢᵀ)),  u ← u + M⁻¹Jᵢᵀ Δλᵢ',
    without: 'Too few sweeps: the load does not travel down a tall stack within a step, and its foot gives way.',
    file: 'solver/reference.rs',
  },
  'solver.warm_start': {
    title: 'Warm start',
    idea: 'A stack that stands needs nearly the same impulses as a step ago. Contacts are found again by what touches what, and start from there.',
    equation: 'λ⁰(t + Δt) = factor · λ(t)',
    without: 'Every step begins from nothing; tall stacks sag, because the sweeps of one step never suffice.',
    file: 'solver/warm_start.rs',
  },
  'solver.weight_amplification': {
    title: 'Weight amplification (WA)',
    idea: 'In each contact the lower body counts as c times as heavy. Each level then seems lighter to the one below, and the load converges geometrically, however tall the stack.',
    equation: 'load seen at the foot = Σⱼ c⁻ʲ  →  c / (c − 1)',
    without: 'The number of sweeps a tower needs grows with the square of its height.',
    file: 'solver/weight_amplification.rs',
  },
  'solver.shock_propagation': {
    title: 'Shock propagation',
    idea: 'Contacts are solved from the ground up, and what is below counts as unmovable: one pass settles a stack. Alone it forgets the weight above; blended with the plain solution it keeps part of it.',
    equation: 'λ = (1 − c) λ₀ + c λ₁',
    without: 'WA is its gentler relative; without either, plain sweeps must carry the load.',
    file: 'solver/shock_propagation.rs',
  },
  'solver.height': {
    title: 'Height',
    idea: '“Lower” means fewer hops from something that does not move, counted over contacts; over joints too, if you like. Shock propagation and WA look at it. Color the bodies by height to see it.',
    equation: 'height(b) = 1 + min over neighbors',
    without: 'Hops can mislead: a plank on two towers of different brick counts has two different ways down.',
    file: 'solver/height.rs',
  },
  'solver.permutation': {
    title: 'Permutation',
    idea: 'Gauss–Seidel favors the row it visits last. Another order in each sweep spreads the error; forwards and backwards in turn carries load both ways.',
    without: 'A fixed order leaves a bias: piles creep to one side.',
    file: 'solver/permutation.rs',
  },
  'solver.manifold_block': {
    title: 'Manifold blocks',
    idea: 'The up to four points of one face share two bodies. Solving their normals together, several passes at each visit, settles how they share the load before anyone else is asked.',
    without: 'Corners of a heavy block take turns, and it rocks.',
    file: 'solver/manifold_block.rs',
  },
  'solver.level_correction': {
    title: 'Level correction',
    idea: 'A sweep carries a load over one contact only. Here all contacts of a stack are solved at once as if they were welds, and what no contact can do is taken back.',
    without: 'Tall towers lean and fall; a light box under a heavy one gives way.',
    file: 'solver/level_correction.rs',
  },
  'solver.hand_down': {
    title: 'Hand-down',
    idea: 'In a stack too wide for level correction each body hands what it is to be rid of to what it stands on, once from the top to the ground.',
    equation: 'f = Gᵀ(GGᵀ)⁻¹p',
    without: 'A pyramid of a hundred rows costs many times as much to hold, or falls.',
    file: 'solver/hand_down.rs',
  },
  'solver.joint_tree': {
    title: 'Joint trees',
    idea: 'All joints of a chain or a ragdoll are solved at once, exactly, at a cost that grows only with their number.',
    without: 'Long chains stretch under heavy loads.',
    file: 'solver/joint_tree.rs',
  },
  'solver.jointed': {
    title: 'Substeps and sweeps of joints',
    idea: 'Ball joints that touch something are swept more often than the rest of the scene, hinges and the like in more substeps; free trees of joints are solved exactly and take fewer.',
    without: 'Ragdolls come apart a little when they fall onto each other.',
    file: 'solver/plan.rs',
  },
  'solver.over_relaxation': {
    title: 'Over-relaxation',
    idea: 'Neighbours take back part of what a joint asked for, so it asks again and again. In the sweep after the motion each joint of a net steps ω times as far.',
    equation: 'Δλ = −ω K⁻¹(J u + bias)',
    without: 'Nets open by a third more, or need another sweep.',
    file: 'solver/over_relaxation.rs',
  },
  'solver.slop': {
    title: 'Slop',
    idea: 'A little overlap is left alone, so that a resting contact stays a contact from step to step.',
    equation: 'error = max(0, depth of overlap − slop)',
    without: 'Contacts flicker on and off, and warm start has nothing to start from.',
    file: 'solver/slop.rs',
  },
  'solver.penetration_recovery': {
    title: 'Penetration recovery',
    idea: 'Rows act on velocities; errors of position drift. A part of the overlap is asked back as a speed in each substep, never faster than a limit.',
    equation: 'v = k · d / Δt',
    without: 'Bodies sink into each other, slowly and for good.',
    file: 'solver/penetration_recovery.rs',
  },
  'solver.joint_recovery': {
    title: 'Joint recovery',
    idea: 'The same for anchors that came apart and axes that bent, but in heaps and nets the bodies are moved: no speed of it stays with them.',
    equation: 'v = k · θ_err / Δt',
    without: 'Chains grow longer and never shrink back.',
    file: 'solver/joint_recovery.rs',
  },
  'solver.friction': {
    title: 'Friction',
    idea: 'Coulomb’s law bounds the tangential impulse by the normal one, as a disk; two fixed tangents with a bound each make a box, simpler and up to √2 too strong on the diagonal.',
    equation: '|λ_t| ≤ μ λ_n',
    without: 'Everything is ice: arches open, piles spread.',
    file: 'constraint/friction.rs',
  },
  'solver.restitution': {
    title: 'Restitution',
    idea: 'Impacts are resolved before resting contacts, so that a bounce does not have to wait for the stack below it.',
    equation: 'w⁺ = −e w⁻',
    without: 'Newton’s cradle swings as one lump.',
    file: 'solver/restitution.rs',
  },
  'rest.sleep': {
    title: 'Sleep',
    idea: 'An island whose bodies have all been slow for a while leaves the simulation until something touches it.',
    without: 'A thousand bodies at rest cost as much as a thousand in motion.',
    file: 'island/sleep.rs',
  },
  'rest.aggressive_sleep': {
    title: 'Aggressive sleep (AS)',
    idea: 'A pair at rest keeps its contact points and skips detection, while its bodies are still simulated: the stack can still feel a load.',
    without: 'Contact points tremble by rounding, and detection is paid for in vain.',
    file: 'island/aggressive_sleep.rs',
  },
  motion: {
    title: 'Rotation',
    idea: 'Without torque angular momentum stays, angular velocity does not. Keep L, compute ω from it: a tumbling body then neither gains nor loses. Try the scene dzhanibekov.',
    equation: 'L = const,  ω = R I⁻¹ Rᵀ L',
    without: 'Explicit Euler in ω gains energy until the body explodes.',
    file: 'motion/angular_momentum.rs',
  },
  contact: {
    title: 'Contact detection',
    idea: 'Contacts are made a little before bodies touch, and bounding boxes are a little larger than their bodies, so that slow motion needs no new search. Fast bodies are swept.',
    without: 'Fast bodies pass through thin walls.',
    file: 'collision/update.rs',
  },
  '': {
    title: 'World',
    idea: 'Gravity, the typical size of a body that all tolerances scale with, and the seed of the random order.',
    file: 'options.rs',
  },
  report: {
    title: 'Measurement',
    idea: 'What the engine measures for the plots beyond the counts. Each costs a pass over bodies or rows.',
    equation: 'residual = ‖λ − clip(λ − w m_eff)‖∞',
    file: 'measure.rs',
  },
};
