// Shaders of the live window.
#ifndef QC_DEMOS_VIEW_SHADERS_H
#define QC_DEMOS_VIEW_SHADERS_H

constexpr char qcSurfaceVertexShader[] = R"(#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
uniform mat4 place, viewProjection, light;
out vec3 worldPosition, worldNormal;
out vec4 inLight;
void main()
{
    vec4 world = place * vec4(position, 1.0);
    worldPosition = world.xyz;
    worldNormal = mat3(place) * normal;
    inLight = light * world;
    gl_Position = viewProjection * world;
}
)";

// Sun, sky and ground light, in linear RGB; a plane has a grid and fades into the sky.
constexpr char qcSurfaceFragmentShader[] = R"(#version 330 core
in vec3 worldPosition, worldNormal;
in vec4 inLight;
uniform vec3 eye, sun, front, back, target;
uniform float fade, grid;
uniform bool isGround;
uniform sampler2DShadow shadowMap;
out vec4 color;

float Lit()
{
    vec3 at = inLight.xyz * 0.5 + 0.5;
    if (any(lessThan(at.xy, vec2(0.0))) || any(greaterThan(at.xy, vec2(1.0))) || at.z > 1.0)
        return 1.0;
    float texel = 1.0 / float(textureSize(shadowMap, 0).x), sum = 0.0;
    for (int x = -1; x <= 1; x++)
        for (int y = -1; y <= 1; y++)
            sum += texture(shadowMap, vec3(at.xy + 1.4 * texel * vec2(x, y), at.z - 0.0006));
    return sum / 9.0;
}

float Line(vec2 at, float spacing)
{
    vec2 p = at / spacing, width = fwidth(p);
    vec2 distance = abs(fract(p - 0.5) - 0.5) / max(width, vec2(1e-6));
    return (1.0 - min(min(distance.x, distance.y), 1.0)) * (1.0 - smoothstep(0.2, 0.6, max(width.x, width.y)));
}

void main()
{
    vec3 toEye = normalize(eye - worldPosition), normal = normalize(worldNormal);
    bool isFront = gl_FrontFacing;
    if (!isFront)
        normal = -normal;
    vec3 base = isFront ? front : back;
    float lit = Lit(), incidence = max(dot(normal, sun), 0.0);
    vec3 sky = mix(vec3(0.16, 0.15, 0.14), vec3(0.36, 0.39, 0.44), normal.y * 0.5 + 0.5);
    vec3 shaded = base * (sky + 1.05 * vec3(1.0, 0.96, 0.88) * incidence * lit);
    float gleam = pow(max(dot(normal, normalize(sun + toEye)), 0.0), 40.0);
    float alpha = 1.0;
    if (isGround)
    {
        float lines = 0.5 * Line(worldPosition.xz, grid) + 0.5 * Line(worldPosition.xz, 5.0 * grid);
        shaded *= 1.0 - 0.22 * lines;
        alpha = 1.0 - smoothstep(0.35 * fade, fade, length(worldPosition - target));
    }
    else
        shaded += 0.12 * gleam * lit;
    color = vec4(pow(shaded, vec3(1.0 / 2.2)), alpha);
}
)";

constexpr char qcShadowVertexShader[] = R"(#version 330 core
layout(location = 0) in vec3 position;
uniform mat4 place, light;
void main()
{
    gl_Position = light * place * vec4(position, 1.0);
}
)";

constexpr char qcShadowFragmentShader[] = R"(#version 330 core
void main()
{
}
)";

// Triangles are shaded a little by their side to the light; lines keep their colour.
constexpr char qcColoredVertexShader[] = R"(#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 vertexColor;
uniform mat4 viewProjection;
out vec3 worldPosition, flatColor;
void main()
{
    worldPosition = position;
    flatColor = vertexColor;
    gl_Position = viewProjection * vec4(position, 1.0);
}
)";

constexpr char qcColoredFragmentShader[] = R"(#version 330 core
in vec3 worldPosition, flatColor;
uniform vec3 sun;
uniform bool shaded;
uniform float alpha;
out vec4 color;
void main()
{
    float light = 1.0;
    if (shaded)
        light = 0.60 + 0.40 * abs(dot(normalize(cross(dFdx(worldPosition), dFdy(worldPosition))), sun));
    color = vec4(flatColor * light, alpha);
}
)";

constexpr char qcSkyVertexShader[] = R"(#version 330 core
out float height;
void main()
{
    vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
    height = corner.y;
    gl_Position = vec4(corner, 0.0, 1.0);
}
)";

constexpr char qcSkyFragmentShader[] = R"(#version 330 core
in float height;
out vec4 color;
void main()
{
    color = vec4(mix(vec3(0.80, 0.82, 0.85), vec3(0.93, 0.94, 0.95), height * 0.5 + 0.5), 1.0);
}
)";

#endif
