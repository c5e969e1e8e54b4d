// Colours of the ways of walks, in the order of the walks, told apart also by who sees red and green alike; each has
// contrast enough to the light and to the dark ground. The first is the page's own.
export const kWalkColours: readonly string[] = ['#0f8378', '#c4560f', '#6a6fd0', '#b03a83', '#7d7a1f', '#3f87b5'];
