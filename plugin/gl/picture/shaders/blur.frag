#version 330 core
// The average of 4 x 4 pixels of about the same depth: one of each angle of light.frag.
uniform sampler2D lights;
out vec4 result;
void main()
{
    ivec2 last = textureSize(lights, 0) - 1;
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec4 own = texelFetch(lights, at, 0);
    vec2 sum = vec2(0.0);
    float weights = 0.0;
    for (int y = -1; y <= 2; ++y)
    {
        for (int x = -1; x <= 2; ++x)
        {
            vec4 other = texelFetch(lights, clamp(at + ivec2(x, y), ivec2(0), last), 0);
            float weight = 1e-4 + max(1.0 - 40.0 * abs(other.z / own.z - 1.0), 0.0);
            sum += weight * other.xy;
            weights += weight;
        }
    }
    result = vec4(sum / weights, own.z, 1.0);
}
