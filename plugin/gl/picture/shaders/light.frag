#version 330 core
// Ambient occlusion, after Bavoil and Sainz: Screen space ambient occlusion (2008), and soft shadows, after Fernando:
// Percentage-closer soft shadows (2005). The samples of a pixel are rotated by one of 16 angles; blur.frag averages them.
uniform sampler2D depths;
uniform sampler2D normals;
uniform sampler2D shadowMap;
uniform vec4 projection;   // clip z = x * depth + y; z, w: pixels of a length of 1 at depth 1
uniform vec3 forward;
uniform vec3 rayX, rayY;   // at depth 1, from the middle of the picture to its borders
uniform mat4 lightClip;    // to 0..1
uniform vec3 lightExtents; // of the shadow map, across and along the light
uniform vec3 light;
out vec4 result; // ambient light, key light, depth

const float pi = 3.14159265;
const float reach = 0.28;         // of ambient occlusion; 1 is half the picture's height at its target
const float maxPenumbra = 0.06;   // radius, in the same unit
const float minPenumbra = 0.004;
const float lightSize = 0.12;     // tangent of its radius seen from the scene
const int occlusionSamples = 14;
const int shadowSamples = 12;
const float goldenAngle = 2.39996323;

float depthAt(vec2 uv)
{
    return projection.y / (2.0 * textureLod(depths, uv, 0.0).r - 1.0 - projection.x);
}

vec3 positionAt(vec2 uv, float depth)
{
    vec2 ndc = 2.0 * uv - 1.0;
    return depth * (forward + ndc.x * rayX + ndc.y * rayY);
}

float ambientLight(vec2 uv, vec3 p, vec3 n, float depth, float angle)
{
    vec2 size = vec2(textureSize(depths, 0));
    vec2 radius = min(reach * projection.zw / depth, vec2(0.25 * size.y)) / size;
    float hidden = 0.0;
    for (int i = 0; i < occlusionSamples; ++i)
    {
        float turn = angle + goldenAngle * float(i);
        float distance = (float(i) + 0.5) / float(occlusionSamples);
        vec2 offset = distance * radius * vec2(cos(turn), sin(turn));
        // The middle of a pixel, whose depth this is: elsewhere a slanted plane would hide itself.
        vec2 at = (floor(clamp((uv + offset) * size, vec2(0.0), size - 1.0)) + 0.5) / size;
        vec3 v = positionAt(at, depthAt(at)) - p;
        // More than rounding makes of a sample in the pixel itself.
        float squared = dot(v, v) + 1e-9 + 1e-11 * depth * depth;
        float near = max(1.0 - squared / (reach * reach), 0.0);
        hidden += near * max(dot(v, n) * inversesqrt(squared) - 0.12, 0.0);
    }
    return max(1.0 - 2.1 * hidden / float(occlusionSamples), 0.0);
}

/// How far a blocker is above the plane of the surface; 0 or less: there is none.
float heightOfBlocker(vec3 at, vec2 plane, vec2 offset, float error)
{
    float found = textureLod(shadowMap, at.xy + offset / lightExtents.xy, 0.0).r;
    float above = (at.z - found) * lightExtents.z + dot(plane, offset) - 0.1 * length(offset) - error;
    return found < 1.0 ? above : 0.0;
}

float keyLight(vec3 p, vec3 n, float depth, float angle)
{
    // A little off the surface: no acne from the map's resolution.
    float texel = max(lightExtents.x, lightExtents.y) / float(textureSize(shadowMap, 0).x);
    vec3 at = (lightClip * vec4(p + 1.5 * texel * n, 1.0)).xyz;
    if (any(lessThan(at.xy, vec2(0.0))) || any(greaterThan(at.xy, vec2(1.0))))
        return 1.0;
    // The error of a position by the depth buffer's 24 bits, and by the map's.
    float error = texel - 2.4e-7 * depth * depth / projection.y + 1.2e-7 * lightExtents.z;
    // The plane of the surface, in the map: how its depth changes across the light.
    vec3 axisX = vec3(lightClip[0].x, lightClip[1].x, lightClip[2].x) * lightExtents.x;
    vec3 axisY = vec3(lightClip[0].y, lightClip[1].y, lightClip[2].y) * lightExtents.y;
    vec2 plane = vec2(dot(n, axisX), dot(n, axisY)) / max(dot(n, light), 0.08);

    float blockers = 0.0, height = 0.0;
    for (int i = 0; i < shadowSamples; ++i)
    {
        float turn = angle + goldenAngle * float(i);
        float distance = maxPenumbra * sqrt((float(i) + 0.5) / float(shadowSamples));
        vec2 offset = distance * vec2(cos(turn), sin(turn));
        float above = heightOfBlocker(at, plane, offset, error);
        blockers += above > 0.0 ? 1.0 : 0.0;
        height += max(above, 0.0);
    }
    if (blockers == 0.0)
        return 1.0;
    float radius = clamp(lightSize * height / blockers, minPenumbra + texel, maxPenumbra);
    float lit = 0.0;
    for (int i = 0; i < shadowSamples; ++i)
    {
        float turn = angle + goldenAngle * float(i);
        float distance = radius * sqrt((float(i) + 0.5) / float(shadowSamples));
        vec2 offset = distance * vec2(cos(turn), sin(turn));
        float above = heightOfBlocker(at, plane, offset, error);
        lit += above > 0.0 ? 0.0 : 1.0;
    }
    return lit / float(shadowSamples);
}

void main()
{
    vec2 uv = gl_FragCoord.xy / vec2(textureSize(depths, 0));
    float depth = depthAt(uv);
    result = vec4(1.0, 1.0, depth, 1.0);
    vec4 stored = textureLod(normals, uv, 0.0);
    if (stored.a == 0.0) // background
        return;
    vec3 n = normalize(2.0 * stored.xyz - 1.0);
    vec3 p = positionAt(uv, depth);
    ivec2 cell = ivec2(gl_FragCoord.xy) & 3;
    float angle = 2.0 * pi * float((cell.x * 5 + cell.y * 7 + cell.x * cell.y * 2) & 15) / 16.0;
    result.x = ambientLight(uv, p, n, depth, angle);
    result.y = dot(n, light) > 0.0 ? keyLight(p, n, depth, angle) : 0.0;
}
