// Reads a texture back as pixels, brought to another size on the way.

const kVertex = `#version 300 es
in vec2 corner;
out vec2 place;
void main() {
  place = vec2(corner.x, 1.0 - corner.y); // pixels are read back from below
  gl_Position = vec4(corner * 2.0 - 1.0, 0.0, 1.0);
}`;
// The mean of four places within the pixel, so that a large picture made small does not flicker.
const kFragment = `#version 300 es
precision mediump float;
uniform sampler2D picture;
uniform vec2 quarter;
in vec2 place;
out vec4 color;
void main() {
  color = 0.25 * (texture(picture, place + quarter) + texture(picture, place - quarter)
    + texture(picture, place + vec2(quarter.x, -quarter.y)) + texture(picture, place + vec2(-quarter.x, quarter.y)));
}`;

export class GlPicture {
  private readonly program: WebGLProgram;
  private readonly corners: WebGLBuffer;
  private readonly target: WebGLTexture;
  private readonly framebuffer: WebGLFramebuffer;
  private size = { width: 0, height: 0 };

  constructor(private readonly gl: WebGL2RenderingContext) {
    this.program = gl.createProgram();
    this.attach(gl.VERTEX_SHADER, kVertex);
    this.attach(gl.FRAGMENT_SHADER, kFragment);
    gl.linkProgram(this.program);
    if (!gl.getProgramParameter(this.program, gl.LINK_STATUS)) {
      throw new Error(`WebGL cannot draw the camera's picture: ${gl.getProgramInfoLog(this.program) ?? ''}`);
    }
    this.corners = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, this.corners);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array([0, 0, 1, 0, 0, 1, 1, 1]), gl.STATIC_DRAW);
    this.target = gl.createTexture();
    this.framebuffer = gl.createFramebuffer();
  }

  // RGBA, row by row from the top.
  read(texture: WebGLTexture, width: number, height: number): Uint8ClampedArray<ArrayBuffer> {
    const { gl } = this;
    this.fit(width, height);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.framebuffer);
    gl.viewport(0, 0, width, height);
    gl.useProgram(this.program);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.uniform1i(gl.getUniformLocation(this.program, 'picture'), 0);
    gl.uniform2f(gl.getUniformLocation(this.program, 'quarter'), 0.25 / width, 0.25 / height);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.corners);
    const corner = gl.getAttribLocation(this.program, 'corner');
    gl.enableVertexAttribArray(corner);
    gl.vertexAttribPointer(corner, 2, gl.FLOAT, false, 0, 0);
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    const pixels = new Uint8Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    return new Uint8ClampedArray(pixels.buffer);
  }

  private fit(width: number, height: number): void {
    if (this.size.width === width && this.size.height === height) {
      return;
    }
    const { gl } = this;
    this.size = { width, height };
    gl.bindTexture(gl.TEXTURE_2D, this.target);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, width, height, 0, gl.RGBA, gl.UNSIGNED_BYTE, null);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.framebuffer);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, this.target, 0);
  }

  private attach(kind: number, source: string): void {
    const { gl } = this;
    const shader = gl.createShader(kind);
    if (shader) {
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(this.program, shader);
    }
  }
}
