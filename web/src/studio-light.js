// The light of the page, as GLSL: a dark studio with one large soft lamp and a strip behind. It is a formula
// and not a texture, so that reflections are cheap also without a graphics processor.

export const STUDIO_LIGHT = /* glsl */ `
  const vec3 LAMP = normalize(vec3(-0.45, 0.82, 0.36));
  const vec3 STRIP = normalize(vec3(0.75, 0.35, -0.55));

  // Radiance from a direction.
  vec3 studio(vec3 d) {
    vec3 room = mix(vec3(0.07, 0.076, 0.095), vec3(0.34, 0.38, 0.46), smoothstep(-0.25, 0.95, d.y));
    room = mix(room, vec3(0.12, 0.113, 0.115), smoothstep(0.0, -0.6, d.y));
    float lamp = smoothstep(0.80, 0.93, dot(d, LAMP));
    float strip = smoothstep(0.90, 0.975, dot(d, STRIP));
    return room + lamp * vec3(3.0, 2.85, 2.6) + strip * vec3(0.75, 0.92, 1.25);
  }

  // Irradiance over pi on a surface with a normal.
  vec3 soft_light(vec3 n) {
    float lamp = max(0.0, 0.15 + 0.85 * dot(n, LAMP));
    float strip = max(0.0, dot(n, STRIP));
    return mix(vec3(0.09, 0.088, 0.095), vec3(0.24, 0.265, 0.32), 0.5 + 0.5 * n.y)
      + lamp * vec3(0.95, 0.90, 0.82) + strip * vec3(0.16, 0.2, 0.28);
  }

  vec3 tone(vec3 c) {
    return c / (1.0 + 0.22 * c);
  }
`;
